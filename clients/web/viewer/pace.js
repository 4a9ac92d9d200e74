// How pictures come: how many a second, how many the display could have had more, and what one costs.

const LEAST_HZ = 45; // a display that shows fewer is one that is kept waiting, unless a picture costs next to nothing
const LEARNED = 60; // intervals from which the display's own is learned

export class Pace {
  constructor() {
    this.begin();
  }

  /** Another display. */
  begin() {
    this.intervals = [];
    this.costs = 0;
    this.targetMs = 1000 / 60;
    this.reset();
  }

  /** Begins to count anew. */
  reset() {
    Object.assign(this, { pictures: 0, dropped: 0, costMs: 0 });
  }

  /**
   * @param {number} intervalMs since the picture before
   * @param {number} costMs of this one
   * @param {number | undefined} displayHz where it is known
   */
  picture(intervalMs, costMs, displayHz) {
    if (displayHz) this.targetMs = 1000 / displayHz;
    else this.#learn(intervalMs, costMs);
    this.pictures++;
    this.costMs += costMs;
    this.dropped += Math.max(0, Math.round(intervalMs / this.targetMs) - 1);
  }

  /** The display's interval is the usual one among the quick ones. */
  #learn(intervalMs, costMs) {
    this.intervals.push(intervalMs);
    this.costs += costMs;
    if (this.intervals.length < LEARNED) return;
    const usual = this.intervals.sort((a, b) => a - b)[Math.floor(LEARNED / 4)];
    this.targetMs = this.costs / LEARNED < usual / 4 ? usual : Math.min(1000 / LEAST_HZ, usual);
    this.intervals = [];
    this.costs = 0;
  }
}
