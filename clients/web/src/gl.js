// WebGL2 itself: the context, what it can do, programs and textures. Knows nothing of the sea.

/**
 * @typedef {object} Gpu
 * @property {WebGL2RenderingContext} gl
 * @property {boolean} float32 RGBA32F can be drawn to and filtered; else half floats stand in
 * @property {number} anisotropy largest, 1 when there is none
 * @property {number | null} anisotropyName
 * @property {ReturnType<typeof makeProgram>} [resolve] what `Fields` draws with, once there is one
 */

/**
 * @param {HTMLCanvasElement} canvas
 * @param {boolean} low spare a weak GPU
 * @returns {Gpu}
 */
export function openGpu(canvas, low) {
  const gl = canvas.getContext('webgl2', {
    alpha: false, antialias: !low, depth: true, powerPreference: 'high-performance',
    xrCompatible: true, // moving to a headset's GPU later would lose it
  });
  if (!gl) throw new Error('this browser has no WebGL2');
  return gpuOf(gl, low);
}

/**
 * What a context can do; extensions that textures need are switched on.
 * @param {WebGL2RenderingContext} gl
 * @param {boolean} low spare a weak GPU
 * @returns {Gpu}
 * @throws {Error} a GPU that can't draw to float textures
 */
export function gpuOf(gl, low = false) {
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
 * @returns {{program: WebGLProgram, at: Record<string, WebGLUniformLocation | null>}} uniforms by name, arrays without [0]
 */
export function makeProgram(gl, name, vertex, fragment) {
  const program = gl.createProgram();
  /** @type {[number, string][]} */
  const stages = [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]];
  for (const [type, body] of stages) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(type)); // null for a type that is none
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
  /** @type {Record<string, WebGLUniformLocation | null>} */
  const at = {};
  const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) ?? 0;
  for (let i = 0; i < count; i++) {
    const uniform = /** @type {WebGLActiveInfo} */ (gl.getActiveUniform(program, i)).name;
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

/**
 * Binds a texture to a unit and points a sampler at it.
 * @param {WebGL2RenderingContext} gl
 * @param {number} unit
 * @param {number} target
 * @param {WebGLTexture | null} texture
 * @param {WebGLUniformLocation | null} location of the sampler
 */
export function bindTexture(gl, unit, target, texture, location) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(target, texture);
  gl.uniform1i(location, unit);
}
