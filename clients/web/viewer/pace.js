// How pictures come: how many a second, how many the display could have had more, and what one costs.

const LEAST_HZ = 45; // a display that shows fewer is one that is kept waiting
const LEARNED = 60; // intervals from which the display's own is learned

export class Pace {
  constructor() {
    this.intervals = [];
    this.targetMs = 1000 / 60;
    this.reset();
  }

  /** Begins to count anew. */
  reset() {
    Object.assign(this, { pictures: 0, dropped: 0, ms: 0, costMs: 0, joinMs: 0 });
  }

  /**
   * @param {number} intervalMs since the picture before
   * @param {number} costMs of this one
   * @param {number} joinMs of that: putting frames together
   * @param {number | undefined} displayHz where it is known
   */
  picture(intervalMs, costMs, joinMs, displayHz) {
    if (displayHz) this.targetMs = 1000 / displayHz;
    else this.#learn(intervalMs);
    this.pictures++;
    this.ms += intervalMs;
    this.costMs += costMs;
    this.joinMs += joinMs;
    this.dropped += Math.max(0, Math.round(intervalMs / this.targetMs) - 1);
  }

  /** The display's interval is the usual one among the quick ones. */
  #learn(intervalMs) {
    this.intervals.push(intervalMs);
    if (this.intervals.length < LEARNED) return;
    const sorted = this.intervals.sort((a, b) => a - b);
    this.targetMs = Math.min(1000 / LEAST_HZ, sorted[Math.floor(LEARNED / 4)]);
    this.intervals = [];
  }
}
