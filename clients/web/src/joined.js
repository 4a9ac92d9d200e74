// The frames of one unit joined in time by the kernels, which hold copies of those around the moment.

import { Kernels } from './kernels.js';

/** @type {Kernels | undefined} of all units of a thread */
let shared;

export class Joined {
  /** @param {import('./unit.js').Unit} unit */
  constructor(unit) {
    const { exports } = this.kernels = shared ??= new Kernels();
    this.unit = unit;
    this.samples = unit.size * unit.size;
    this.length = unit.channels * this.samples;
    /** @type {{tick: number, name: number}[]} frames as whole patches, four at most */
    this.frames = [];
    this.name = exports.take_values(this.length);
    this.values = this.kernels.values(this.name, this.length);
  }

  /** Sees that the frames of the moment last sought are there. */
  hold() {
    const { pick, ring } = this.unit;
    /** @type {number[]} */
    const wanted = [];
    for (let i = 0; i < pick.points; i++) wanted.push(ring.ticks[pick.slots[i]]);
    for (let i = 0; i < pick.points; i++) {
      if (this.frames.some(({ tick }) => tick === wanted[i])) continue;
      let place = this.frames.find(({ tick }) => !wanted.includes(tick));
      if (!place) this.frames.push(place = { tick: -1, name: this.kernels.exports.take_counts(this.length) });
      place.tick = wanted[i];
      this.#copy(pick.slots[i], this.kernels.counts(place.name, 0, this.length));
    }
  }

  /**
   * The moment last sought, of which the frames are held.
   * @returns {Float32Array} `[channel][z][x]`, good until more memory is taken
   */
  join() {
    const { unit, kernels, samples } = this, { pick, ring } = unit;
    const names = [0, 0, 0, 0], weights = [0, 0, 0, 0];
    for (let i = 0; i < 4; i++) {
      const slot = pick.slots[Math.min(i, pick.points - 1)];
      names[i] = /** @type {{name: number}} */ (this.frames.find(({ tick }) => tick === ring.ticks[slot])).name;
    }
    const [a, b, c, d] = names;
    for (let channel = 0; channel < unit.channels; channel++) {
      for (let i = 0; i < pick.points; i++) weights[i] = pick.weights[i] * unit.step(pick.slots[i], channel);
      const [wa, wb, wc, wd] = weights;
      kernels.exports.join(this.name, channel, samples, a, b, c, d, wa, wb, wc, wd);
    }
    // Where memory grew, it lies elsewhere now.
    if (this.values.length === 0) this.values = kernels.values(this.name, this.length);
    return this.values;
  }

  /** Gives all memory back. */
  dispose() {
    for (const { name } of this.frames) this.kernels.exports.give_counts(name);
    this.kernels.exports.give_values(this.name);
  }

  /** @param {number} slot @param {Int16Array} patch filled in */
  #copy(slot, patch) {
    const { unit, samples } = this, { size, channels } = unit;
    for (const { n, tileX, tileZ, counts } of unit.frames[slot]) {
      if (!counts) continue;
      for (let row = 0; row < channels * n; row++) {
        const channel = Math.floor(row / n), z = tileZ * n + row % n;
        patch.set(counts.subarray(row * n, (row + 1) * n), channel * samples + z * size + tileX * n);
      }
    }
  }
}
