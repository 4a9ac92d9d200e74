// The frames of one unit, held as they came: which of them make a moment, and what they say then.

import { Joined } from './joined.js';
import { Pick, Ring, RING_SLOTS } from './ring.js';

/** @typedef {import('./decode.js').DecodedFrame} DecodedFrame */

export class Unit {
  /**
   * @param {number} group index into GROUPS
   * @param {number} channels
   * @param {number} size samples a side of the whole patch at this level
   * @param {number} interval ticks between frames
   * @param {number} level
   */
  constructor(group, channels, size, interval, level) {
    this.group = group;
    this.channels = channels;
    this.size = size;
    this.level = level;
    this.across = Math.max(1, size / 256); // tiles
    this.ring = new Ring(interval, this.across * this.across);
    /** What was chosen by the last `seek`. */
    this.pick = new Pick();
    /** @type {DecodedFrame[][]} by slot of the ring: tiles, in the order in which they came */
    this.frames = Array.from({ length: RING_SLOTS }, () => []);
    /** @type {Joined | null} what `sample` joins counts by */
    this.joined = null;
    /** @type {Float32Array | null} what it fills in where there are none */
    this.values = null;
    /** @type {{dispose(): void} | null} what draws from this unit: let go of with it */
    this.attached = null;
  }

  /**
   * @param {DecodedFrame} frame of this unit
   * @param {DecodedFrame[]} [spent] filled in: those in whose place it is
   * @returns {boolean} whether it was of use
   */
  accept(frame, spent) {
    if (frame.levelN !== this.size) return false;
    const before = frame.tick / this.ring.interval % RING_SLOTS;
    const fresh = this.ring.ticks[before] !== frame.tick;
    const slot = this.ring.place(frame.tick);
    if (slot < 0) return false;
    if (fresh) {
      spent?.push(...this.frames[slot]);
      this.frames[slot].length = 0;
    }
    this.frames[slot].push(frame);
    return true;
  }

  /**
   * Chooses the frames for a time.
   * @param {number} tick
   * @returns {Pick}
   */
  seek(tick) {
    return this.ring.pick(tick, this.pick);
  }

  /**
   * Metres (or 1) a count of a channel in a slot; 1 where frames are values themselves.
   * @param {number} slot
   * @param {number} channel
   */
  step(slot, channel) {
    const first = this.frames[slot][0];
    if (!first) return 0;
    return first.counts ? first.step[channel] : 1;
  }

  /** Takes what memory `sample` needs. */
  prepare() {
    if (this.pick.points > 0 && this.#counted()) (this.joined ??= new Joined(this)).hold();
    else this.values ??= new Float32Array(this.channels * this.size * this.size);
  }

  /**
   * All samples at the moment last sought, which was prepared.
   * @returns {Float32Array} `[channel][z][x]` in metres (or 1); filled in anew by the next call
   */
  sample() {
    const { size, channels, pick } = this, plane = size * size;
    if (this.joined && pick.points > 0 && this.#counted()) return this.joined.join();
    const values = /** @type {Float32Array} */ (this.values);
    if (pick.points === 0) return values.fill(0);
    for (let place = 0; place < this.across * this.across; place++) {
      const tileX = place % this.across, tileZ = Math.floor(place / this.across), n = size / this.across;
      const tiles = [0, 1, 2, 3].map((i) => valuesOf(this.#tile(pick.slots[Math.min(i, pick.points - 1)], tileX, tileZ)));
      for (let c = 0; c < channels; c++) {
        const weights = tiles.map((_, i) => (i < pick.points ? pick.weights[i] * this.step(pick.slots[i], c) : 0));
        join(tiles, weights, c * n * n, n, values, c * plane + tileZ * n * size + tileX * n, size);
      }
    }
    return values;
  }

  /**
   * One place at the moment last sought, bilinear between samples; added to `sums`.
   * @param {number} u along x, in patches
   * @param {number} v along z
   * @param {number[]} sums a number a channel
   */
  add(u, v, sums) {
    const { pick, size } = this;
    const px = (u - Math.floor(u)) * size, pz = (v - Math.floor(v)) * size;
    const ix = Math.min(Math.floor(px), size - 1), iz = Math.min(Math.floor(pz), size - 1), fx = px - ix, fz = pz - iz;
    const jx = (ix + 1) % size, jz = (iz + 1) % size;
    for (let i = 0; i < pick.points; i++) {
      const slot = pick.slots[i];
      for (let c = 0; c < sums.length; c++) {
        const low = this.#at(slot, c, ix, iz) * (1 - fx) + this.#at(slot, c, jx, iz) * fx;
        const high = this.#at(slot, c, ix, jz) * (1 - fx) + this.#at(slot, c, jx, jz) * fx;
        sums[c] += pick.weights[i] * this.step(slot, c) * (low * (1 - fz) + high * fz);
      }
    }
  }

  dispose() {
    this.attached?.dispose();
    this.joined?.dispose();
    this.attached = this.joined = null;
  }

  /** Whether all frames of the moment are counts. */
  #counted() {
    const { pick } = this;
    for (let i = 0; i < pick.points; i++) if (this.frames[pick.slots[i]].some(({ counts }) => !counts)) return false;
    return true;
  }

  /** @param {number} slot @param {number} channel @param {number} x @param {number} z */
  #at(slot, channel, x, z) {
    const n = this.size / this.across;
    const tile = valuesOf(this.#tile(slot, Math.floor(x / n), Math.floor(z / n)));
    return tile[channel * n * n + (z % n) * n + x % n];
  }

  /** @param {number} slot @param {number} tileX @param {number} tileZ */
  #tile(slot, tileX, tileZ) {
    const tiles = this.frames[slot];
    let i = 0;
    while (i + 1 < tiles.length && (tiles[i].tileX !== tileX || tiles[i].tileZ !== tileZ)) i++;
    return tiles[i];
  }
}

/**
 * Counts of a frame, or its values.
 * @param {DecodedFrame} frame
 * @returns {Int16Array | Float32Array}
 */
function valuesOf(frame) {
  return frame.counts ?? /** @type {Float32Array} */ (frame.floats);
}

/**
 * The weighted sum of one channel of four tiles, written into a plane.
 * @param {(Int16Array | Float32Array)[]} tiles
 * @param {number[]} weights
 * @param {number} from where the channel begins in each
 * @param {number} n samples a side of a tile
 * @param {Float32Array} out
 * @param {number} to where the tile's first sample goes
 * @param {number} stride of `out`
 */
function join([a, b, c, d], [wa, wb, wc, wd], from, n, out, to, stride) {
  for (let z = 0; z < n; z++) {
    let i = from + z * n, o = to + z * stride;
    for (const end = i + n; i < end; i++, o++) out[o] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i];
  }
}
