// The counts of a tile at its recent ticks: what its later frames are predicted from, the same at both ends.
//
// Invariant: three frames of layer 0 at most, newest first, and the newest of layer 1. Their memory is used again and
// again, so what is kept is a copy.

import { BETWEEN, layerOf, MAX_DEPTH, SLOWEST_INTERVAL } from './frame.js';

/** @typedef {{tick: number, name: number}} Kept `name`: of its counts among the kernels' */

export class History {
  /**
   * @param {import('./kernels.js').Kernels} kernels that read planes
   * @param {string} epoch
   * @param {number} channels
   * @param {number} samples of a channel
   */
  constructor(kernels, epoch, channels, samples) {
    this.kernels = kernels;
    this.epoch = epoch;
    this.channels = channels;
    this.samples = samples;
    /** @type {Kept[]} the newest first */
    this.base = [];
    /** @type {Kept | null} */
    this.middle = null;
    /** @type {Kept[]} memory of what is no longer held */
    this.spare = [];
  }

  /**
   * What a frame is predicted from.
   * @param {number} tick
   * @param {number} depth above 0
   * @returns {Kept[] | null} as many as the depth asks for; null where one is not held
   */
  basis(tick, depth) {
    const count = depth === BETWEEN ? 2 : depth, gap = (SLOWEST_INTERVAL / 2) >> (layerOf(tick) - 1);
    const found = [];
    for (let i = 0; i < count; i++) {
      const kept = this.#at(depth === BETWEEN ? tick - gap + 2 * gap * i : tick - (i + 1) * SLOWEST_INTERVAL);
      if (!kept) return null;
      found.push(kept);
    }
    return found;
  }

  /**
   * Keeps a frame, where others may be predicted from it.
   * @param {number} tick
   * @param {Int16Array} counts copied
   */
  keep(tick, counts) {
    const layer = layerOf(tick);
    if (layer === 0) {
      // A frame again, or one of another past: what is newer has nothing to do with it.
      while (this.base.length > 0 && this.base[0].tick >= tick) this.spare.push(/** @type {Kept} */ (this.base.shift()));
      if (this.base.length === MAX_DEPTH) this.spare.push(/** @type {Kept} */ (this.base.pop()));
      this.base.unshift(this.#copy(tick, counts));
    } else if (layer === 1) {
      if (this.middle) this.spare.push(this.middle);
      this.middle = this.#copy(tick, counts);
    }
  }

  /** Gives all memory back. */
  dispose() {
    for (const kept of [...this.base, ...this.spare, ...(this.middle ? [this.middle] : [])]) {
      this.kernels.exports.give_counts(kept.name);
    }
    this.base = this.spare = [];
    this.middle = null;
  }

  /** @param {number} tick @param {Int16Array} counts */
  #copy(tick, counts) {
    const size = this.channels * this.samples;
    const kept = this.spare.pop() ?? { tick, name: this.kernels.exports.take_counts(size) };
    kept.tick = tick;
    this.kernels.counts(kept.name, 0, size).set(counts);
    return kept;
  }

  /** @param {number} tick */
  #at(tick) {
    for (const kept of this.base) if (kept.tick === tick) return kept;
    return this.middle?.tick === tick ? this.middle : null;
  }
}
