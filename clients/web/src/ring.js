// Which frames to show at a time, and with which weights. Knows ticks and slots, nothing of pixels.
//
// Frames of a unit lie on an absolute grid of ticks, and come in any order: those of 15 Hz first, those between them
// later, or not at all where a client is given fewer. A ring holds a few of them; the four around a time, whatever lies
// between, are joined by the Lagrange cubic through them, fewer at the edges. Never beyond the last frame: it is held,
// and counted as starved.

import { SLOWEST_INTERVAL } from './frame.js';

/**
 * At 60 Hz the server is 14 frames ahead, and a curve needs two behind: at most eight intervals away, where only frames
 * of 15 Hz come.
 */
export const RING_SLOTS = 24;

/** How far apart frames may lie and still be joined by a curve, in ticks: three frames of the lowest rate. */
const MAX_GAP = 3 * SLOWEST_INTERVAL;

/** What to show: four slots of the ring and their weights (unused ones weigh 0). */
export class Pick {
  constructor() {
    this.slots = new Int32Array(4);
    this.weights = new Float64Array(4);
    this.points = 0; // frames used: 0 means nothing to show
    this.starved = false; // the time lies outside the frames held
  }
}

export class Ring {
  /**
   * @param {number} interval ticks between frames
   * @param {number} tiles frames of one tick that make a whole patch
   */
  constructor(interval, tiles = 1) {
    this.interval = interval;
    this.tiles = tiles;
    this.ticks = new Float64Array(RING_SLOTS).fill(-1); // what a slot holds or gathers
    this.have = new Int32Array(RING_SLOTS); // tiles there
    this.newest = -1; // newest whole tick
    this.nodes = new Float64Array(4);
  }

  /**
   * Where a frame belongs. The caller writes it there at once.
   * @param {number} tick
   * @returns {number} slot, or -1 for a frame to drop: off the grid, or older than what is held
   */
  place(tick) {
    if (tick % this.interval !== 0) return -1;
    const slot = (tick / this.interval) % RING_SLOTS;
    if (this.ticks[slot] > tick) return -1;
    if (this.ticks[slot] !== tick) {
      this.ticks[slot] = tick;
      this.have[slot] = 0;
    } else if (this.have[slot] >= this.tiles) {
      return -1; // a duplicate
    }
    this.have[slot]++;
    if (this.have[slot] === this.tiles && tick > this.newest) this.newest = tick;
    return slot;
  }

  /**
   * @param {number} tick time to show, not a whole number in general
   * @param {Pick} pick filled in
   * @returns {Pick}
   */
  pick(tick, pick) {
    const { ticks, have, tiles, nodes } = this;
    // The two newest frames at or before the time and the two oldest after it.
    let b1 = -1, b2 = -1, a1 = -1, a2 = -1;
    for (let s = 0; s < RING_SLOTS; s++) {
      const t = ticks[s];
      if (t < 0 || have[s] < tiles) continue;
      if (t <= tick) {
        if (b1 < 0 || t > ticks[b1]) { b2 = b1; b1 = s; } else if (b2 < 0 || t > ticks[b2]) b2 = s;
      } else if (a1 < 0 || t < ticks[a1]) { a2 = a1; a1 = s; } else if (a2 < 0 || t < ticks[a2]) a2 = s;
    }
    pick.slots.fill(0);
    pick.weights.fill(0);
    pick.starved = b1 < 0 || (a1 < 0 && ticks[b1] !== tick);
    if (b1 < 0 && a1 < 0) {
      pick.points = 0;
      return pick;
    }
    if (pick.starved || ticks[b1] === tick) {
      pick.slots[0] = b1 < 0 ? a1 : b1;
      pick.weights[0] = 1;
      pick.points = 1;
      return pick;
    }
    const smooth = ticks[a1] - ticks[b1] <= MAX_GAP;
    let count = 0;
    const use = (/** @type {number} */ slot) => { pick.slots[count] = slot; nodes[count++] = ticks[slot]; };
    if (smooth && b2 >= 0 && ticks[b1] - ticks[b2] <= MAX_GAP) use(b2);
    use(b1);
    use(a1);
    if (smooth && a2 >= 0 && ticks[a2] - ticks[a1] <= MAX_GAP) use(a2);
    lagrange(nodes, count, tick, pick.weights);
    pick.points = count;
    return pick;
  }

  /**
   * Whether a whole frame lies at a time or before it.
   * @param {number} tick
   */
  reaches(tick) {
    return this.ticks.some((t, slot) => t >= 0 && t <= tick && this.have[slot] === this.tiles);
  }
}

/**
 * Weights of the polynomial through `count` nodes, at `t`.
 * @param {Float64Array} nodes
 * @param {number} count
 * @param {number} t
 * @param {Float64Array} weights filled in
 */
export function lagrange(nodes, count, t, weights) {
  for (let i = 0; i < count; i++) {
    let w = 1;
    for (let j = 0; j < count; j++) if (j !== i) w *= (t - nodes[j]) / (nodes[i] - nodes[j]);
    weights[i] = w;
  }
}
