// The counts of a tile at its recent ticks: what its later frames are predicted from, the same at both ends.
//
// Invariant: three frames of layer 0 at most, newest first, and the newest of layer 1. Their memory is used again and
// again, so what is kept is a copy.

import { BETWEEN, layerOf, MAX_DEPTH, SLOWEST_INTERVAL } from './frame.js';
import { NOTHING } from './predict.js';

class Kept {
  /** @param {number} channels @param {number} samples */
  constructor(channels, samples) {
    this.tick = -1;
    this.counts = new Int16Array(channels * samples);
    this.planes = Array.from({ length: channels }, (_, c) => this.counts.subarray(c * samples, (c + 1) * samples));
  }
}

export class History {
  /**
   * @param {string} epoch
   * @param {number} channels
   * @param {number} samples of a channel
   */
  constructor(epoch, channels, samples) {
    this.epoch = epoch;
    this.channels = channels;
    this.samples = samples;
    /** @type {Kept[]} the newest first */
    this.base = [];
    /** @type {Kept | null} */
    this.middle = null;
    /** @type {Kept[]} memory of what is no longer held */
    this.spare = [];
    this.found = [NOTHING, NOTHING, NOTHING];
  }

  /**
   * What channel `channel` of a frame is predicted from.
   * @param {number} tick
   * @param {number} depth above 0
   * @param {number} channel
   * @returns {Int16Array[] | null} three, good until the next call; null where something is not held
   */
  basis(tick, depth, channel) {
    const { found } = this;
    found.fill(NOTHING);
    const count = depth === BETWEEN ? 2 : depth, gap = (SLOWEST_INTERVAL / 2) >> (layerOf(tick) - 1);
    for (let i = 0; i < count; i++) {
      const kept = this.#at(depth === BETWEEN ? tick - gap + 2 * gap * i : tick - (i + 1) * SLOWEST_INTERVAL);
      if (!kept) return null;
      found[i] = kept.planes[channel];
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

  /** @param {number} tick @param {Int16Array} counts */
  #copy(tick, counts) {
    const kept = this.spare.pop() ?? new Kept(this.channels, this.samples);
    kept.tick = tick;
    kept.counts.set(counts);
    return kept;
  }

  /** @param {number} tick */
  #at(tick) {
    for (const kept of this.base) if (kept.tick === tick) return kept;
    return this.middle?.tick === tick ? this.middle : null;
  }
}
