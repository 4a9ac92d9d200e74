// What isn't water: the boat, the mark of a teleport, a board with words. Triangles in plain colours, lit by the sun.

import { makeProgram } from '../src/gl.js';
import { FREEBOARD_M, LENGTH_M, WIDTH_M } from './deck.js';

const VERTEX = `
layout(location = 0) in vec3 aPlace;
layout(location = 1) in vec3 aColor;
layout(location = 2) in vec2 aPicture; // texture coordinates; negative: none
uniform mat4 uModel;
uniform vec3 uEye;
uniform mat4 uView; // clip from eye-relative
out vec3 vColor;
out vec3 vFromEye;
out vec2 vPicture;
void main() {
  vFromEye = (uModel * vec4(aPlace, 1.0)).xyz - uEye;
  vColor = aColor;
  vPicture = aPicture;
  gl_Position = uView * vec4(vFromEye, 1.0);
}`;

const FRAGMENT = `
in vec3 vColor;
in vec3 vFromEye;
in vec2 vPicture;
uniform vec3 uSun;
uniform sampler2D uPicture;
out vec4 oColor;
void main() {
  if (vPicture.x >= 0.0) {
    oColor = vec4(texture(uPicture, vPicture).rgb, 1.0);
    return;
  }
  vec3 normal = normalize(cross(dFdx(vFromEye), dFdy(vFromEye)));
  normal *= -sign(dot(normal, vFromEye));
  oColor = vec4(vColor * (0.55 + 0.45 * max(dot(normal, uSun), 0.0)), 1.0);
}`;

const PICTURE = [512, 256];

export class Solids {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.pass = makeProgram(gl, 'solids', VERTEX, FRAGMENT);
    this.boat = makeMesh(gl, boat());
    this.mark = makeMesh(gl, mark());
    this.board = makeMesh(gl, [...panel(0.64, 0.32)]);
    this.canvas = document.createElement('canvas');
    [this.canvas.width, this.canvas.height] = PICTURE;
    this.picture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.picture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, ...PICTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  }

  /** @param {string[]} lines */
  write(lines) {
    const { gl, canvas } = this, context = canvas.getContext('2d');
    context.fillStyle = '#0b1d2b';
    context.fillRect(0, 0, ...PICTURE);
    context.fillStyle = '#eef4f8';
    context.font = '38px system-ui, sans-serif';
    lines.forEach((line, i) => context.fillText(line, 24, 54 + i * 48));
    gl.bindTexture(gl.TEXTURE_2D, this.picture);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
  }

  /**
   * @param {import('./view.js').View} view
   * @param {Float32Array} sun
   * @param {{mesh: object, model: Float32Array}[]} things
   */
  draw(view, sun, things) {
    const { gl } = this, { program, at } = this.pass;
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform3fv(at.uEye, view.eye);
    gl.uniformMatrix4fv(at.uView, false, view.clip);
    gl.uniform3fv(at.uSun, sun);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.picture);
    gl.uniform1i(at.uPicture, 0);
    for (const { mesh, model } of things) {
      gl.uniformMatrix4fv(at.uModel, false, model);
      gl.bindVertexArray(mesh.array);
      gl.drawArrays(gl.TRIANGLES, 0, mesh.count);
    }
    gl.bindVertexArray(null);
  }
}

/** Numbers of a vertex: place, colour, texture coordinates. */
const STRIDE = 8;

function makeMesh(gl, numbers) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
  [[3, 0], [3, 12], [2, 24]].forEach(([size, offset], index) => {
    gl.enableVertexAttribArray(index);
    gl.vertexAttribPointer(index, size, gl.FLOAT, false, STRIDE * 4, offset);
  });
  gl.bindVertexArray(null);
  return { array, count: numbers.length / STRIDE };
}

/** Two triangles between four corners, in order around. */
function* quad(corners, color, picture) {
  const NONE = [-1, -1];
  for (const i of [0, 1, 2, 0, 2, 3]) yield* [...corners[i], ...color, ...(picture?.[i] ?? NONE)];
}

function* box([x0, y0, z0], [x1, y1, z1], color) {
  const p = (i) => [i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? z1 : z0];
  for (const side of [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]) {
    yield* quad(side.map(p), color);
  }
}

/** Planks, hull and a low rail. Metres to starboard, up from the deck, towards the bow. */
function boat() {
  const half = WIDTH_M / 2, end = LENGTH_M / 2, planks = 12, out = [];
  for (let i = 0; i < planks; i++) {
    const x = -half + i * WIDTH_M / planks, shade = 0.9 + 0.1 * ((i * 7) % 3 - 1);
    out.push(...box([x + 0.01, -0.05, -end], [x + WIDTH_M / planks - 0.01, 0, end], [0.52 * shade, 0.38 * shade, 0.24 * shade]));
  }
  out.push(...box([-half, -FREEBOARD_M - 0.8, -end], [half, -0.05, end], [0.12, 0.17, 0.22]));
  const white = [0.82, 0.83, 0.82];
  for (const [from, to] of [[[-half, -end], [-half, end]], [[half, -end], [half, end]], [[-half, end], [half, end]], [[-half, -end], [half, -end]]]) {
    out.push(...box([from[0] - 0.03, 0.85, from[1] - 0.03], [to[0] + 0.03, 0.9, to[1] + 0.03], white));
    for (let i = 0; i <= 4; i++) {
      const x = from[0] + (to[0] - from[0]) * i / 4, z = from[1] + (to[1] - from[1]) * i / 4;
      out.push(...box([x - 0.02, 0, z - 0.02], [x + 0.02, 0.85, z + 0.02], white));
    }
  }
  return out;
}

/** A flat ring of half a metre. */
function mark() {
  const out = [], steps = 24, color = [0.95, 0.75, 0.2];
  const at = (i, r) => [r * Math.cos(i / steps * 2 * Math.PI), 0.05, r * Math.sin(i / steps * 2 * Math.PI)];
  for (let i = 0; i < steps; i++) out.push(...quad([at(i, 0.35), at(i + 1, 0.35), at(i + 1, 0.5), at(i, 0.5)], color));
  return out;
}

/** A board that faces +z, its picture upright. */
function panel(width, height) {
  const x = width / 2, y = height / 2;
  return quad([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]], [1, 1, 1], [[0, 0], [1, 0], [1, 1], [0, 1]]);
}
