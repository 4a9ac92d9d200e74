// Draws one picture: sky, then water. Owns the GPU's state; reads fields, camera and weather.

import { Fields, MOST_CASCADES } from './fields.js';
import { makeFoamTexture } from './foam.js';
import { bindTexture, COVER_VERTEX, makeProgram, openGpu } from './gl.js';
import { Grid } from './grid.js';
import { SkyMap } from './sky.js';
import { BACKGROUND_FRAGMENT, WATER_FRAGMENT, WATER_VERTEX } from './water.js';

const EXPOSURE = 0.72;
const HAZE_M = 16_000;
const FADE_PATCHES = [9, 26]; // a cascade goes before its repetition can be counted
const UPLOADS_AHEAD = 4;

/**
 * @typedef {object} Weather
 * @property {number | null} windMps null when the sea is not wind-driven
 * @property {number} windFromDeg where the wind comes from, clockwise from north
 * @property {number} hsM significant wave height
 */

export class Renderer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{sun: number[], ripples: boolean, scale: number, detail: string}} options
   */
  constructor(canvas, options) {
    this.canvas = canvas;
    this.options = options;
    const low = options.detail === 'low';
    this.gpu = openGpu(canvas, low);
    const { gl } = this.gpu;
    this.grid = new Grid(gl, low ? 64 : 128);
    this.sky = new SkyMap(this.gpu);
    this.foam = makeFoamTexture(this.gpu);
    this.background = makeProgram(gl, 'background', COVER_VERTEX, BACKGROUND_FRAGMENT);
    this.sun = new Float32Array(3);
    this.setSun(options.sun[0], options.sun[1]);
    this.crestwise = [0, 0];
    this.fields = null;
    const most = `#define MOST ${MOST_CASCADES}\n`;
    this.water = makeProgram(gl, 'water', most + WATER_VERTEX, most + WATER_FRAGMENT);
    this.patches = new Float32Array(4 * MOST_CASCADES);
    this.longest = new Float32Array(MOST_CASCADES);
    this.layers = new Float32Array(MOST_CASCADES);
    this.planes = Array.from({ length: 5 }, () => new Float64Array(3));
    this.view = new Float32Array(16);
    this.turn = new Float32Array(9);
    this.sees = (box) => this.planes.every((p) => reaches(p, box));
  }

  /** Azimuth clockwise from north and elevation, degrees. */
  setSun(azimuth, elevation) {
    const a = azimuth * Math.PI / 180, e = Math.max(1, elevation) * Math.PI / 180;
    this.sun.set([Math.sin(a) * Math.cos(e), Math.sin(e), -Math.cos(a) * Math.cos(e)]);
    this.sky.draw(this.sun);
  }

  /** Another sea begins, and everything held is forgotten; or the same goes on in another layout. */
  setSea(layout, plan, goesOn) {
    const before = this.fields;
    this.fields = new Fields(this.gpu, layout, plan, goesOn ? before : null);
    before?.dispose();
  }

  /**
   * @param {number} tick time to show; NaN before there is one
   * @param {import('../camera.js').Camera} camera
   * @param {Weather} weather
   * @returns {{drawn: boolean, starved: boolean}}
   */
  draw(tick, camera, weather) {
    const { gl } = this.gpu;
    this.#fit();
    const from = weather.windFromDeg * Math.PI / 180;
    this.crestwise = weather.windMps === null ? [0, 0] : [Math.cos(from), Math.sin(from)];
    let starved = false;
    if (this.fields && Number.isFinite(tick)) {
      starved = this.fields.seek(tick, this.crestwise);
      this.fields.uploadAhead(tick, UPLOADS_AHEAD);
    }
    this.#look(camera);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.#drawSky();
    const drawn = Boolean(this.fields?.complete);
    if (drawn) this.#drawWater(camera, weather);
    return { drawn, starved: drawn && starved };
  }

  #fit() {
    const scale = this.options.scale || Math.min(2, window.devicePixelRatio || 1);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
  }

  #look(camera) {
    const { right, up, forward, near } = camera.axes();
    const ty = Math.tan(camera.fov / 2), tx = ty * this.canvas.width / this.canvas.height;
    this.lens = [tx, ty];
    for (let i = 0; i < 3; i++) {
      this.view[i * 4] = right[i] / tx;
      this.view[i * 4 + 1] = up[i] / ty;
      this.view[i * 4 + 2] = forward[i];
      this.view[i * 4 + 3] = forward[i];
      this.turn[i] = right[i];
      this.turn[3 + i] = up[i];
      this.turn[6 + i] = -forward[i];
      this.planes[0][i] = forward[i];
      this.planes[1][i] = forward[i] * tx + right[i];
      this.planes[2][i] = forward[i] * tx - right[i];
      this.planes[3][i] = forward[i] * ty + up[i];
      this.planes[4][i] = forward[i] * ty - up[i];
    }
    this.view[14] = -2 * near; // the far plane lies at infinity
  }

  #drawSky() {
    const { gl } = this.gpu;
    const { program, at } = this.background;
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform4f(at.uLens, this.lens[0], this.lens[1], 0, 0);
    gl.uniformMatrix3fv(at.uTurn, false, this.turn);
    gl.uniform3fv(at.uSun, this.sun);
    gl.uniform1f(at.uExposure, EXPOSURE);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  #drawWater(camera, weather) {
    const { gl } = this.gpu;
    const { fields, grid } = this;
    const { program, at } = this.water;
    const eye = camera.eye;
    grid.moveTo(eye[0], eye[2]);
    fields.active.forEach((layer, i) => {
      const patch = fields.patches[layer];
      this.layers[i] = layer;
      this.longest[i] = fields.longest[layer];
      // Sample (0, 0) stands for the origin and lies in the middle of its texel.
      const middle = 0.5 / fields.size;
      this.patches[i * 4] = fraction(grid.origin[0] / patch) + middle;
      this.patches[i * 4 + 1] = fraction(grid.origin[1] / patch) + middle;
      this.patches[i * 4 + 2] = 1 / patch;
      this.patches[i * 4 + 3] = fields.size / patch;
    });
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform4fv(at.uPatch, this.patches);
    gl.uniform1fv(at.uLongest, this.longest);
    gl.uniform1fv(at.uLayer, this.layers);
    gl.uniform1i(at.uCount, fields.active.length);
    gl.uniform1i(at.uFinest, Math.max(0, fields.active.indexOf(fields.finest)));
    gl.uniform3f(at.uEye, eye[0] - grid.origin[0], eye[1], eye[2] - grid.origin[1]);
    gl.uniformMatrix4fv(at.uView, false, this.view);
    gl.uniform3fv(at.uSun, this.sun);
    gl.uniform2f(at.uFade, FADE_PATCHES[0], FADE_PATCHES[1]);
    gl.uniform1f(at.uRipples, this.options.ripples ? 0.6 : 0);
    gl.uniform1f(at.uCrest, Math.max(0.2, 0.4 * weather.hsM));
    gl.uniform2f(at.uCrestwise, this.crestwise[0], this.crestwise[1]);
    gl.uniform1f(at.uExposure, EXPOSURE);
    gl.uniform1f(at.uHaze, 1 / HAZE_M);
    // Cox & Munk 1954: the mean square slope of the whole sea, wind at 12.5 m taken as that at 10 m.
    gl.uniform2f(at.uMeanSquareSlope, weather.windMps === null ? 0 : 0.003 + 5.12e-3 * weather.windMps, 0.002);
    bindTexture(gl, 0, gl.TEXTURE_2D_ARRAY, fields.displacement, at.uDisplacement);
    bindTexture(gl, 1, gl.TEXTURE_2D_ARRAY, fields.moment, at.uMoment);
    bindTexture(gl, 2, gl.TEXTURE_2D_ARRAY, fields.gradient, at.uGradient);
    bindTexture(gl, 3, gl.TEXTURE_2D_ARRAY, fields.shear, at.uShear);
    bindTexture(gl, 4, gl.TEXTURE_2D, this.sky.texture, at.uSky);
    bindTexture(gl, 5, gl.TEXTURE_2D, this.foam, at.uFoamPattern);
    grid.draw(at, eye, 2 + 2 * weather.hsM, this.sees);
  }
}

function fraction(x) {
  return x - Math.floor(x);
}

/** Whether some point of a box lies on the inner side of a plane through the eye. */
function reaches(p, box) {
  return p[0] * box[p[0] > 0 ? 3 : 0] + p[1] * box[p[1] > 0 ? 4 : 1] + p[2] * box[p[2] > 0 ? 5 : 2] >= 0;
}
