// The frames of one unit: a ring of them, held as they came, and its texture on the GPU.
// A frame is uploaded when it is needed, or ahead of that when there is time.

import { Pick, Ring, RING_SLOTS } from '../playback.js';

export class Unit {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {number} channels
   * @param {number} size samples a side of the whole patch at this level
   * @param {number} interval ticks between frames
   * @param {number} level
   */
  constructor(gl, channels, size, interval, level) {
    this.gl = gl;
    this.channels = channels;
    this.size = size;
    this.level = level;
    const tilesAcross = Math.max(1, size / 256);
    this.ring = new Ring(interval, tilesAcross * tilesAcross);
    this.pick = new Pick();
    this.frames = Array.from({ length: RING_SLOTS }, () => []); // tiles, as decoded
    this.uploaded = new Int32Array(RING_SLOTS); // tiles on the GPU
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.R16I, size, size, RING_SLOTS * channels);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  /**
   * @param {import('../decode.js').DecodedFrame} frame
   * @returns {boolean} whether it was of use
   */
  accept(frame) {
    if (frame.levelN !== this.size) return false;
    const before = frame.tick / this.ring.interval % RING_SLOTS;
    const fresh = this.ring.ticks[before] !== frame.tick;
    const slot = this.ring.place(frame.tick);
    if (slot < 0) return false;
    if (fresh) {
      this.frames[slot].length = 0;
      this.uploaded[slot] = 0;
    }
    this.frames[slot].push(frame);
    return true;
  }

  /** Chooses the frames for a time and sees that they are on the GPU. */
  seek(tick) {
    const pick = this.ring.pick(tick, this.pick);
    for (let i = 0; i < pick.points; i++) this.#upload(pick.slots[i]);
    return pick;
  }

  /**
   * Uploads one frame that will be needed later.
   * @returns {boolean} whether there was one
   */
  uploadAhead(tick) {
    const { ticks, have } = this.ring;
    for (let slot = 0; slot < RING_SLOTS; slot++) {
      if (ticks[slot] > tick && this.uploaded[slot] < have[slot]) {
        this.#upload(slot);
        return true;
      }
    }
    return false;
  }

  /** Metres (or 1) per count of a channel in a slot. */
  step(slot, channel) {
    return this.frames[slot].length > 0 ? this.frames[slot][0].step[channel] : 0;
  }

  dispose() {
    this.gl.deleteTexture(this.texture);
  }

  #upload(slot) {
    const { gl, channels } = this;
    const tiles = this.frames[slot];
    if (this.uploaded[slot] === tiles.length) return;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.texture);
    for (let i = this.uploaded[slot]; i < tiles.length; i++) {
      const t = tiles[i];
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, t.tileX * t.n, t.tileZ * t.n, slot * channels,
        t.n, t.n, channels, gl.RED_INTEGER, gl.SHORT, t.counts);
    }
    this.uploaded[slot] = tiles.length;
  }
}
