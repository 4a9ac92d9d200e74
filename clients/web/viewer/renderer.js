// Draws pictures: sky, then water, in one view or in several. Owns the GPU's state; reads playback and weather.

import { Fields, meanSquareSlope } from '../src/fields.js';
import { bindTexture, COVER_VERTEX, makeProgram, openGpu } from '../src/gl.js';
import { MOST_CASCADES } from '../src/playback.js';
import { makeFoamTexture } from './foam.js';
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
    this.grids = [new Grid(gl, 128), new Grid(gl, 64)];
    this.setMesh(low);
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
    this.weather = { windMps: null, windFromDeg: 0, hsM: 2 };
  }

  /** Azimuth clockwise from north and elevation, degrees. */
  setSun(azimuth, elevation) {
    const a = azimuth * Math.PI / 180, e = Math.max(1, elevation) * Math.PI / 180;
    this.sun.set([Math.sin(a) * Math.cos(e), Math.sin(e), -Math.cos(a) * Math.cos(e)]);
    this.sky.draw(this.sun);
  }

  /** A coarse mesh, for a GPU that has no time for a fine one. */
  setMesh(coarse) {
    this.grid = this.grids[coarse ? 1 : 0];
  }

  /**
   * Another sea begins, or the same goes on in another layout or quality.
   * @param {import('../src/playback.js').Playback} playback
   */
  setSea(playback) {
    this.fields?.dispose();
    this.fields = new Fields(this.gpu, playback);
  }

  /**
   * Goes to a moment: all that is painted until the next call is of it.
   * @param {number} tick NaN before there is one
   * @param {Weather} weather
   * @returns {{drawn: boolean, starved: boolean}} whether there is water to draw
   */
  seek(tick, weather) {
    this.weather = weather;
    const from = weather.windFromDeg * Math.PI / 180;
    this.crestwise = weather.windMps === null ? [0, 0] : [Math.cos(from), Math.sin(from)];
    if (!this.fields || !Number.isFinite(tick)) return { drawn: false, starved: false };
    const starved = this.fields.seek(tick, this.crestwise);
    this.fields.uploadAhead(tick, UPLOADS_AHEAD);
    const drawn = this.fields.playback.complete;
    return { drawn, starved: drawn && starved };
  }

  /** Sets the canvas to the size at which it is shown. */
  fit() {
    const scale = this.options.scale || Math.min(2, window.devicePixelRatio || 1);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
  }

  /**
   * @param {import('./view.js').View[]} views
   * @param {WebGLFramebuffer | null} framebuffer
   * @param {(view: import('./view.js').View) => void} [more] what else is in the world
   */
  paint(views, framebuffer, more) {
    const { gl } = this.gpu;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.enable(gl.SCISSOR_TEST); // nothing of one eye's view in the other's
    for (const view of views) {
      gl.viewport(...view.viewport);
      gl.scissor(...view.viewport);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      this.#drawSky(view);
      if (this.fields?.playback.complete) this.#drawWater(view);
      more?.(view);
    }
    gl.disable(gl.SCISSOR_TEST);
  }

  #drawSky(view) {
    const { gl } = this.gpu;
    const { program, at } = this.background;
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform4fv(at.uLens, view.lens);
    gl.uniformMatrix3fv(at.uTurn, false, view.turn);
    gl.uniform3fv(at.uSun, this.sun);
    gl.uniform1f(at.uExposure, EXPOSURE);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  #drawWater(view) {
    const { gl } = this.gpu;
    const { fields, grid, weather } = this, { active, finest } = fields.playback;
    const { program, at } = this.water;
    const { eye } = view;
    grid.moveTo(eye[0], eye[2]);
    active.forEach((layer, i) => {
      this.layers[i] = layer;
      this.longest[i] = fields.longest[layer];
      this.patches.set(fields.placeOf(layer, grid.origin[0], grid.origin[1]), i * 4);
    });
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform4fv(at.uPatch, this.patches);
    gl.uniform1fv(at.uLongest, this.longest);
    gl.uniform1fv(at.uLayer, this.layers);
    gl.uniform1i(at.uCount, active.length);
    gl.uniform1i(at.uFinest, Math.max(0, active.indexOf(finest)));
    gl.uniform3f(at.uEye, eye[0] - grid.origin[0], eye[1], eye[2] - grid.origin[1]);
    gl.uniformMatrix4fv(at.uView, false, view.clip);
    gl.uniform3fv(at.uSun, this.sun);
    gl.uniform2f(at.uFade, FADE_PATCHES[0], FADE_PATCHES[1]);
    gl.uniform1f(at.uRipples, this.options.ripples ? 0.6 : 0);
    gl.uniform1f(at.uCrest, Math.max(0.2, 0.4 * weather.hsM));
    gl.uniform2f(at.uCrestwise, this.crestwise[0], this.crestwise[1]);
    gl.uniform1f(at.uExposure, EXPOSURE);
    gl.uniform1f(at.uHaze, 1 / HAZE_M);
    gl.uniform2f(at.uMeanSquareSlope, meanSquareSlope(weather.windMps), 0.002);
    bindTexture(gl, 0, gl.TEXTURE_2D_ARRAY, fields.displacement, at.uDisplacement);
    bindTexture(gl, 1, gl.TEXTURE_2D_ARRAY, fields.moment, at.uMoment);
    bindTexture(gl, 2, gl.TEXTURE_2D_ARRAY, fields.gradient, at.uGradient);
    bindTexture(gl, 3, gl.TEXTURE_2D_ARRAY, fields.shear, at.uShear);
    bindTexture(gl, 4, gl.TEXTURE_2D, this.sky.texture, at.uSky);
    bindTexture(gl, 5, gl.TEXTURE_2D, this.foam, at.uFoamPattern);
    grid.draw(at, eye, 2 + 2 * weather.hsM, view.sees);
  }
}
