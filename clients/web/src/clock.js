// The server's time as this client sees it. Pure: own time is always an argument (milliseconds).
//
// Four timestamps give offset and round trip of an exchange. Delay only ever adds, so an exchange
// errs by at most half of what its round trip exceeds the shortest one. The best exchanges are
// fitted by a line (offset and drift), by least absolute deviation in effect (reweighted squares).

import { TICKS_PER_SECOND } from './messages.js';

const CAPACITY = 128;
const STEP_MS = 200;
const SLEW = 0.01;
const MAX_DRIFT = 3e-4; // no crystal is worse
const DRIFT_SPAN_MS = 10_000;
const AGE_ERROR = 2e-5; // what the drift may change by, per unit of time

export class Clock {
  constructor() {
    this.reset();
  }

  /** Forgets everything: another timeline begins. */
  reset() {
    this.samples = []; // {at, offset, rtt}, oldest first
    this.fit = null; // {at, offset, drift}
    this.boundMs = Infinity;
    this.shown = null; // {at, server}: what was shown last, for slewing
    this.steps = 0;
  }

  /**
   * One `time` exchange.
   * @param {number} t0 own time when the request was sent, ms
   * @param {number} t1 server time when it was read, ms
   * @param {number} t2 server time when the answer was written, ms
   * @param {number} t3 own time when it came, ms
   */
  exchange(t0, t1, t2, t3) {
    const rtt = t3 - t0 - (t2 - t1);
    if (!(rtt >= 0) || !Number.isFinite(t1 + t2)) return;
    const sample = { at: (t0 + t3) / 2, offset: ((t1 - t0) + (t2 - t3)) / 2, rtt };
    // A server clock that was set, or a machine that slept: nothing held is true any more.
    if (this.fit && Math.abs(sample.offset - this.#offsetAt(sample.at)) > STEP_MS + rtt / 2) this.samples.length = 0;
    this.samples.push(sample);
    if (this.samples.length > CAPACITY) this.samples.shift();
    this.#refit();
  }

  /** Whether there is any time to show. */
  get synced() {
    return this.fit !== null;
  }

  /**
   * Server time to show, never backwards, slewed by at most 1 %.
   * @param {number} now own time, ms; not before an earlier call's
   * @returns {number} ms since tick 0, or NaN before the first exchange
   */
  serverMs(now) {
    if (!this.fit) return NaN;
    const wanted = now + this.#offsetAt(now);
    if (!this.shown || Math.abs(wanted - (this.shown.server + now - this.shown.at)) > STEP_MS) {
      if (this.shown) this.steps++;
      this.shown = { at: now, server: wanted };
      return wanted;
    }
    const elapsed = now - this.shown.at;
    const free = this.shown.server + elapsed;
    const most = SLEW * elapsed;
    this.shown.server = free + Math.min(most, Math.max(-most, wanted - free));
    this.shown.at = now;
    return this.shown.server;
  }

  /**
   * @param {number} now own time, ms
   * @returns {number} server time in ticks, not rounded
   */
  serverTick(now) {
    return this.serverMs(now) * (TICKS_PER_SECOND / 1000);
  }

  /**
   * Half the shortest round trip held (what no exchange can tell) is the part of the bound that
   * asymmetry of the path can use up; the rest is spread of the good samples, age and slewing.
   * @param {number} now own time, ms
   * @returns {{boundMs: number, spreadMs: number, rttMs: number}}
   */
  quality(now) {
    if (!this.fit) return { boundMs: Infinity, spreadMs: Infinity, rttMs: Infinity };
    const newest = this.samples[this.samples.length - 1].at;
    const slewing = this.shown ? Math.abs(now + this.#offsetAt(now) - (this.shown.server + now - this.shown.at)) : 0;
    const spread = this.spread + Math.max(0, now - newest) * AGE_ERROR + slewing;
    return { boundMs: this.minRtt / 2 + spread, spreadMs: spread, rttMs: this.minRtt };
  }

  #offsetAt(at) {
    return this.fit.offset + this.fit.drift * (at - this.fit.at);
  }

  #refit() {
    const samples = this.samples;
    const sorted = samples.map((s) => s.rtt).sort((a, b) => a - b);
    this.minRtt = sorted[0];
    const limit = sorted[Math.max(0, Math.ceil(samples.length / 4) - 1)];
    const good = samples.filter((s) => s.rtt <= limit);
    const span = good[good.length - 1].at - good[0].at;
    const line = good.length >= 8 && span > DRIFT_SPAN_MS;

    // Weight by how far the round trip is above the shortest: that is what bounds the error.
    const slack = Math.max(0.05, (limit - this.minRtt) / 4);
    const base = good.map((s) => 1 / (slack + (s.rtt - this.minRtt) / 2) ** 2);
    const at = good[good.length - 1].at;
    const origin = good[0].offset;
    let weights = base;
    let a = 0, b = 0;
    for (let round = 0; round < 4; round++) {
      let s0 = 0, s1 = 0, s2 = 0, y0 = 0, y1 = 0;
      good.forEach((s, i) => {
        const w = weights[i], x = s.at - at, y = s.offset - origin;
        s0 += w; s1 += w * x; s2 += w * x * x; y0 += w * y; y1 += w * x * y;
      });
      const det = s0 * s2 - s1 * s1;
      b = line && det > 0 ? (s0 * y1 - s1 * y0) / det : 0;
      b = Math.min(MAX_DRIFT, Math.max(-MAX_DRIFT, b));
      a = (y0 - b * s1) / s0;
      const errors = good.map((s) => Math.abs(s.offset - origin - a - b * (s.at - at)));
      const scale = Math.max(0.02, median(errors));
      weights = base.map((w, i) => w / Math.max(1, errors[i] / (2 * scale)));
      this.spread = 2 * scale / Math.sqrt(good.length) + 0.02;
    }
    this.fit = { at, offset: origin + a, drift: b };
  }
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[sorted.length >> 1];
}
