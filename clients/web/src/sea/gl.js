// WebGL2 itself: the context, what it can do, programs and textures. Knows nothing of the sea.

/**
 * @typedef {object} Gpu
 * @property {WebGL2RenderingContext} gl
 * @property {boolean} float32 RGBA32F can be drawn to and filtered; else half floats stand in
 * @property {number} anisotropy largest, 1 when there is none
 * @property {number | null} anisotropyName
 */

/**
 * @param {HTMLCanvasElement} canvas
 * @param {boolean} low spare a weak GPU
 * @returns {Gpu}
 */
export function openGpu(canvas, low) {
  const gl = canvas.getContext('webgl2', {
    alpha: false, antialias: !low, depth: true, powerPreference: 'high-performance',
  });
  if (!gl) throw new Error('this browser has no WebGL2');
  const float = gl.getExtension('EXT_color_buffer_float');
  if (!float && !gl.getExtension('EXT_color_buffer_half_float')) {
    throw new Error('this GPU cannot draw to float textures (EXT_color_buffer_float, _half_float)');
  }
  const linear = gl.getExtension('OES_texture_float_linear');
  const aniso = gl.getExtension('EXT_texture_filter_anisotropic');
  return {
    gl,
    float32: Boolean(float && linear),
    anisotropy: aniso ? Math.min(low ? 2 : 8, gl.getParameter(aniso.MAX_TEXTURE_MAX_ANISOTROPY_EXT)) : 1,
    anisotropyName: aniso ? aniso.TEXTURE_MAX_ANISOTROPY_EXT : null,
  };
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {string} name for messages
 * @param {string} vertex GLSL without the version line
 * @param {string} fragment GLSL without the version line
 * @returns {{program: WebGLProgram, at: Record<string, WebGLUniformLocation>}} uniforms by name, arrays without [0]
 */
export function makeProgram(gl, name, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, body] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, `#version 300 es\nprecision highp float;\nprecision highp int;\n${body}`);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    gl.deleteShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
      throw new Error(`${name}: ${gl.getShaderInfoLog(shader)}`);
    }
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`${name}: ${gl.getProgramInfoLog(program)}`);
  }
  const at = {};
  const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) ?? 0;
  for (let i = 0; i < count; i++) {
    const uniform = gl.getActiveUniform(program, i).name;
    at[uniform.replace('[0]', '')] = gl.getUniformLocation(program, uniform);
  }
  return { program, at };
}

/** A triangle that covers the target, from gl_VertexID alone. */
export const COVER_VERTEX = `
out vec2 vCover;
void main() {
  vCover = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  gl_Position = vec4(vCover, 0.0, 1.0);
}`;

/** Binds a texture to a unit and points a sampler at it. */
export function bindTexture(gl, unit, target, texture, location) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(target, texture);
  gl.uniform1i(location, unit);
}
