// The texture of one unit's frames: counts as they came, a layer a channel and slot.
// A frame is uploaded when it is needed, or ahead of that when there is time.

import { RING_SLOTS } from './ring.js';

export class FrameTexture {
  /**
   * The one that belongs to a unit.
   * @param {WebGL2RenderingContext} gl
   * @param {import('./unit.js').Unit} unit
   * @returns {FrameTexture}
   */
  static of(gl, unit) {
    if (unit.attached instanceof FrameTexture) return unit.attached;
    const texture = new FrameTexture(gl, unit);
    unit.attached = texture;
    return texture;
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('./unit.js').Unit} unit
   */
  constructor(gl, unit) {
    this.gl = gl;
    this.unit = unit;
    this.ticks = new Float64Array(RING_SLOTS).fill(-1); // what lies there
    this.tiles = new Int32Array(RING_SLOTS); // and how much of it
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.R16I, unit.size, unit.size, RING_SLOTS * unit.channels);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  /** Sees that the frames of the moment last sought are there. */
  upload() {
    const { slots, points } = this.unit.pick;
    for (let i = 0; i < points; i++) this.#upload(slots[i]);
  }

  /**
   * Uploads one frame that will be needed later.
   * @param {number} tick
   * @returns {boolean} whether there was one
   */
  uploadAhead(tick) {
    const { ticks } = this.unit.ring;
    for (let slot = 0; slot < RING_SLOTS; slot++) {
      if (ticks[slot] > tick && this.#upload(slot)) return true;
    }
    return false;
  }

  dispose() {
    this.gl.deleteTexture(this.texture);
  }

  /** @param {number} slot */
  #upload(slot) {
    const { gl, unit } = this, { channels } = unit, tiles = unit.frames[slot];
    if (this.ticks[slot] !== unit.ring.ticks[slot]) {
      this.ticks[slot] = unit.ring.ticks[slot];
      this.tiles[slot] = 0;
    }
    if (this.tiles[slot] === tiles.length) return false;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    for (let i = this.tiles[slot]; i < tiles.length; i++) {
      const t = tiles[i];
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, t.tileX * t.n, t.tileZ * t.n, slot * channels,
        t.n, t.n, channels, gl.RED_INTEGER, gl.SHORT, t.counts);
    }
    this.tiles[slot] = tiles.length;
    return true;
  }
}
