// How a connection fares: what it tells the server about once a second, so that it is given what it can take.

import { TICKS_PER_SECOND } from './messages.js';

export class Fares {
  constructor() {
    this.reset();
  }

  /** Begins anew: another subscription. */
  reset() {
    this.newest = 0; // tick of all that was decoded: of a cascade that has ended nothing comes
    this.last = -1;
    this.ticks = 0; // since the last report: frames of how many ticks, and what they took
    this.ms = 0;
  }

  /**
   * Counts a frame.
   * @param {number} tick
   * @param {number} ms that decoding took
   */
  decoded(tick, ms) {
    this.newest = Math.max(this.newest, tick);
    if (tick !== this.last) this.ticks++; // frames of one tick stand together
    this.last = tick;
    this.ms += ms;
  }

  /**
   * @param {number} serverUs server time now; NaN where it is not known
   * @returns {{tick: number, decode_ms: number, buffer_ms: number}}
   */
  report(serverUs) {
    const ahead = (this.newest * 1e6 / TICKS_PER_SECOND - serverUs) / 1000;
    const report = { tick: this.newest, decode_ms: this.ms / Math.max(1, this.ticks), buffer_ms: Number.isNaN(ahead) ? 0 : ahead };
    this.ticks = this.ms = 0;
    return report;
  }
}
