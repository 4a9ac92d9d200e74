// Keeps an eye above the water: it lifts at once and lets down gently.

const LOWEST_M = 0.7; // above the water below

export class Lift {
  constructor() {
    this.metres = 0;
  }

  /**
   * @param {number} y where the eye would be, metres
   * @param {number} water height of the water below it; -Infinity where nothing is known
   * @param {number} seconds since the last call
   * @returns {number} where it is
   */
  above(y, water, seconds) {
    this.metres = Math.max(0, water + LOWEST_M - y, this.metres * Math.exp(-seconds));
    return y + this.metres;
  }
}
