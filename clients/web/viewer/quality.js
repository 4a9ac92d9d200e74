// Gives way before pictures are dropped: first in layers (frames a second), then in level, at last in the mesh.
//
// What a picture costs is compared with the time there is for it; dropped pictures count where that is not known.

const WINDOW_MS = 1000;
/** Shares of the time for a picture: above the one it gives way, below the other for a while it takes back a step. */
const TIGHT = 0.75, EASY = 0.4;
const DROPPED = 0.03; // share of the pictures
const PATIENCE = 10; // windows; each step that had to be given up again doubles it
const MOST_PATIENCE = 160;

/**
 * @typedef {{rate: number, level: number, coarse: boolean}} Step
 */

/**
 * From what is wished to the least, one step at a time.
 * @param {{rate: number, level: number}} wish
 * @param {number} levels of the cascades
 * @returns {Step[]}
 */
export function stepsOf({ rate, level }, levels) {
  const steps = [{ rate, level, coarse: false }];
  for (const lower of [30, 15]) if (lower < rate) steps.push({ rate: lower, level, coarse: false });
  const last = steps[steps.length - 1];
  for (let l = level + 1; l <= Math.min(level + 2, levels - 1); l++) steps.push({ ...last, level: l });
  steps.push({ ...steps[steps.length - 1], coarse: true });
  return steps;
}

export class Quality {
  /** @param {Step[]} steps */
  constructor(steps) {
    this.steps = steps;
    this.at = 0;
    this.patience = PATIENCE;
    this.easy = 0; // windows in a row
    this.#begin();
  }

  /**
   * Takes a picture.
   * @param {number} intervalMs since the one before
   * @param {number} costMs of this one
   * @param {number} targetMs how often the display shows one
   * @param {boolean} whole the cost is all of it; else pictures that were dropped tell of the rest
   * @returns {Step | null} what to go to
   */
  picture(intervalMs, costMs, targetMs, whole) {
    this.ms += intervalMs;
    this.pictures++;
    this.cost += costMs;
    if (!whole) this.dropped += Math.max(0, Math.round(intervalMs / targetMs) - 1);
    if (this.ms < WINDOW_MS) return null;
    const load = this.cost / (this.pictures * targetMs), lost = this.dropped / (this.pictures + this.dropped);
    this.#begin();
    if (load > TIGHT || lost > DROPPED) {
      if (this.easy < 0) this.patience = Math.min(MOST_PATIENCE, 2 * this.patience);
      this.easy = 0;
      return this.#go(1);
    }
    if (load >= EASY || lost > 0) {
      this.easy = 0;
      return null;
    }
    if (++this.easy < this.patience) return null;
    this.easy = -PATIENCE; // on trial: if it has to give way within these windows, it waits longer the next time
    return this.#go(-1);
  }

  #begin() {
    this.ms = this.pictures = this.cost = this.dropped = 0;
  }

  #go(by) {
    const to = Math.max(0, Math.min(this.steps.length - 1, this.at + by));
    if (to === this.at) return null;
    this.at = to;
    return this.steps[to];
  }
}
