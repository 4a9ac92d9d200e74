// How a connection fares: what it tells the server about once a second, so that it is given what it can take.

import { TICKS_PER_SECOND } from './messages.js';

/**
 * @typedef {object} Report
 * @property {number} tick the newest of a frame that was decoded, 0 before the first
 * @property {number} decode_ms what decoding the frames of one tick took, on average
 * @property {number} buffer_ms how far that tick lies ahead of now; below 0 when it is past
 */

export class Fares {
  constructor() {
    this.newest = 0; // tick of all that was decoded: of a cascade that has ended nothing comes
    this.last = -1;
    this.ticks = 0; // since the last report: frames of how many ticks, and what they took
    this.ms = 0;
  }

  /** Begins anew: another subscription. */
  reset() {
    Object.assign(this, new Fares());
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
   * @returns {Report}
   */
  report(serverUs) {
    const ahead = (this.newest * 1e6 / TICKS_PER_SECOND - serverUs) / 1000;
    const decodeMs = this.ms / Math.max(1, this.ticks), bufferMs = Number.isNaN(ahead) ? 0 : ahead;
    const report = { tick: this.newest, decode_ms: decodeMs, buffer_ms: bufferMs };
    this.ticks = this.ms = 0;
    return report;
  }
}
