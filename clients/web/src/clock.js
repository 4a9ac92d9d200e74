// The server's time as this client sees it. Pure: own time is always an argument (milliseconds).
//
// Delay only ever adds. So with f = t1 - t0 and g = t2 - t3 of every exchange, the true offset lies
// below all f and above all g: a corridor, bounded by the exchanges that were fast one way, which
// need not be the same ones. The line (offset and drift) through the middle of the widest corridor
// is the estimate (Moon, Skelly & Towsley 1999), half the corridor's width its bound. A late message
// can't move it; exchanges that leave no corridor say that the clocks have changed.

import { TICKS_PER_SECOND } from './messages.js';

const CAPACITY = 128;
const STEP_MS = 200;
const SLEW = 0.01;
const MAX_DRIFT = 3e-4; // no crystal is worse
const DRIFT_SPAN_MS = 10_000, LONG_SPAN_MS = 60_000;
const MIN_FOR_DRIFT = 16;
const AGE_ERROR = 2e-5; // what the drift may be wrong by, per unit of time

export class Clock {
  constructor() {
    this.reset();
  }

  /** Forgets everything: another timeline begins. */
  reset() {
    this.samples = []; // {at, offset, rtt, above, below}, oldest first
    this.fit = null; // {at, offset, drift}
    this.gap = Infinity; // width of the corridor, ms
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
    const sample = { at: (t0 + t3) / 2, offset: ((t1 - t0) + (t2 - t3)) / 2, rtt, above: t1 - t0, below: t2 - t3 };
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
   * How wrong the time shown may be: half the corridor, what drift may have added since, and what
   * is still being slewed.
   * @param {number} now own time, ms
   * @returns {{boundMs: number, rttMs: number}}
   */
  quality(now) {
    if (!this.fit) return { boundMs: Infinity, rttMs: Infinity };
    const slewing = this.shown ? Math.abs(now + this.#offsetAt(now) - (this.shown.server + now - this.shown.at)) : 0;
    const age = Math.max(0, now - this.fit.at) * (this.fit.known ? AGE_ERROR : MAX_DRIFT);
    return { boundMs: this.gap / 2 + age + slewing, rttMs: Math.min(...this.samples.map((s) => s.rtt)) };
  }

  #offsetAt(at) {
    return this.fit.offset + this.fit.drift * (at - this.fit.at);
  }

  #refit() {
    for (;;) {
      const { samples } = this;
      const newest = samples[samples.length - 1], at = newest.at, origin = newest.offset;
      const corridor = (drift) => {
        let top = Infinity, bottom = -Infinity;
        for (const s of samples) {
          const shift = drift * (s.at - at) + origin;
          top = Math.min(top, s.above - shift);
          bottom = Math.max(bottom, s.below - shift);
        }
        return { gap: top - bottom, middle: origin + (top + bottom) / 2 };
      };
      // Drift can be told once it would show against the corridor's width.
      const span = at - samples[0].at;
      const known = samples.length >= MIN_FOR_DRIFT && span >= DRIFT_SPAN_MS
        && (span >= LONG_SPAN_MS || corridor(0).gap < span * AGE_ERROR);
      const drift = known ? widest(corridor) : 0;
      const { gap, middle } = corridor(drift);
      if (gap >= 0 || samples.length === 1) {
        this.fit = { at, offset: middle, drift, known };
        this.gap = Math.max(0, gap);
        return;
      }
      // A contradiction. While drift is not known yet it is the likely cause, and small; later it is a
      // clock that was set. Either way the older half is what no longer holds.
      samples.splice(0, samples.length >> 1);
    }
  }
}

/** The drift with the widest corridor; its width is concave in the drift. */
function widest(corridor) {
  let low = -MAX_DRIFT, high = MAX_DRIFT;
  for (let i = 0; i < 40; i++) {
    const a = low + (high - low) * 0.382, b = low + (high - low) * 0.618;
    if (corridor(a).gap < corridor(b).gap) low = a; else high = b;
  }
  return (low + high) / 2;
}
