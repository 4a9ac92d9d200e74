// The shared clock: server time from four timestamps of each exchange. Pure: own time is always an argument.
// All times are microseconds. The same algorithm as src/client/clock.rs, held to the same proto/vectors/clock.json.
//
// An exchange bounds the offset from both sides, whatever the network did: it is at most t1 - t0 (the request took no
// negative time) and at least t2 - t3. Delay only ever loosens these bounds, so the tight ones are the good samples:
// the line below every upper bound and the line above every lower bound enclose the truth (Moon, Skelly & Towsley
// 1999), and their middle is right by as much as the quickest requests and the quickest answers take equally long.

/** Exchanges that are kept. */
const SAMPLES = 128;
/** A jump of server time larger than this is followed at once. */
const STEP_US = 200_000;
/** Share of passing time by which server time is bent towards the truth otherwise. */
const SLEW = 0.01;
/** No two clocks differ more in rate: twice what a poor crystal is off. */
const MAX_DRIFT = 200e-6;
/** What two clocks usually differ: a slope is trusted as far as its noise is below this. */
const USUAL_DRIFT = 50e-6;
/** Noise of a slope, times the span of the samples, as a share of half the least round trip; found by simulation. */
const SLOPE_NOISE = 0.1;
/** Times beyond this are nobody's: 36,000 years. */
const MAX_US = 2 ** 60;

/**
 * @typedef {object} Exchange t0 and t3 by our clock, t1 and t2 by the server's
 * @property {number} t0 when we sent the request
 * @property {number} t1 when the server read it
 * @property {number} t2 when it wrote its answer
 * @property {number} t3 when we read the answer
 */

/** @typedef {{ours: number, offset: number}} Origin */
/** @typedef {{x: number, y: number}} Point own time and offset, both from the origin on */
/** @typedef {{offset: number, drift: number, halfWidth: number, bound: number}} Fit */

export class Clock {
  constructor() {
    /** @type {Exchange[]} the oldest first */
    this.exchanges = [];
    /** @type {Origin} at the last fit; everything else is relative to it, so that it stays exact */
    this.origin = { ours: 0, offset: 0 };
    /** @type {Fit | null} */
    this.fit = null;
    this.lag = 0; // what server time still lacks to the fit at the origin
    this.contradictions = 0; // exchanges in a row that the fit says can't be
  }

  /** Forgets everything: another timeline begins. */
  reset() {
    Object.assign(this, new Clock());
  }

  /**
   * Takes one exchange.
   * @param {Exchange} exchange
   * @returns {boolean} whether it was possible; an impossible one changes nothing
   */
  observe(exchange) {
    if (!isPossible(exchange)) return false;
    const { t2, t3 } = exchange;
    const before = this.serverUs(t3);
    if (this.#contradicts(exchange)) {
      // One of our clocks was set or stood still: the old samples say nothing about the new time. Two in a row, so that
      // one wild answer doesn't throw away a good fit.
      if (++this.contradictions < 2) return true;
      this.exchanges.length = 0;
    }
    this.contradictions = 0;
    if (this.exchanges.length === SAMPLES) this.exchanges.shift();
    this.exchanges.push(exchange);
    this.origin = { ours: t3, offset: t2 - t3 };
    let fit = fitOf(this.exchanges, this.origin);
    while (fit.halfWidth < 0 && this.exchanges.length > 1) {
      // Bounds that exclude one another: the clocks ran apart, or one was moved a little. The newer ones are right.
      this.exchanges.shift();
      fit = fitOf(this.exchanges, this.origin);
    }
    this.fit = fit;
    const lag = Number.isNaN(before) ? 0 : before - (t3 + this.origin.offset + round(fit.offset));
    this.lag = Math.abs(lag) > STEP_US ? 0 : lag;
    return true;
  }

  /** Whether there is any time to show. */
  get synced() {
    return this.fit !== null;
  }

  /**
   * @param {number} now own time
   * @returns {number} server time since tick 0; NaN before the first exchange
   */
  serverUs(now) {
    if (!this.fit) return NaN;
    const { ours, offset } = this.origin;
    const passed = now - ours;
    const lag = Math.sign(this.lag) * Math.max(0, Math.abs(this.lag) - SLEW * Math.max(0, passed));
    return ours + passed + offset + round(this.fit.offset + this.fit.drift * passed + lag);
  }

  /**
   * How far server time can be off: the truth lies within it even if one direction took no time and the clocks' rates
   * differ as much as clocks may.
   * @param {number} now own time
   * @returns {number} Infinity before the first exchange
   */
  errorBoundUs(now) {
    if (!this.fit) return Infinity;
    const passed = Math.max(0, now - this.origin.ours);
    return Math.ceil(this.fit.bound + Math.max(0, Math.abs(this.lag) - SLEW * passed) + MAX_DRIFT * passed);
  }

  /** By how much the server's clock runs faster than ours, as a share. */
  get drift() {
    return this.fit?.drift ?? 0;
  }

  /**
   * Whether an exchange rules out the fit by more than a step.
   * @param {Exchange} exchange
   */
  #contradicts({ t0, t1, t2, t3 }) {
    const { fit, origin } = this;
    if (!fit) return false;
    const at = (/** @type {number} */ t) => origin.offset + fit.offset + fit.drift * (t - origin.ours);
    return at(t0) > t1 - t0 + STEP_US || at(t3) < t2 - t3 - STEP_US;
  }
}

/**
 * Whether these four can be times of one exchange.
 * @param {Exchange} exchange
 */
function isPossible({ t0, t1, t2, t3 }) {
  const within = [t0, t1, t2, t3].every((t) => Math.abs(t) <= MAX_US); // not so for a NaN
  return within && t3 >= t0 && t2 >= t1 && t2 - t1 <= t3 - t0;
}

/**
 * The middle between the line below all upper bounds and the line above all lower bounds.
 * @param {Exchange[]} exchanges
 * @param {Origin} origin
 * @returns {Fit}
 */
function fitOf(exchanges, origin) {
  /** @type {(ours: number, theirs: number) => Point} */
  const point = (ours, theirs) => ({ x: ours - origin.ours, y: theirs - ours - origin.offset });
  const upper = exchanges.map((e) => point(e.t0, e.t1)), lower = exchanges.map((e) => point(e.t3, e.t2));
  const span = upper[upper.length - 1].x - upper[0].x;
  const mirrored = lower.map(({ x, y }) => ({ x, y: -y }));
  const steepest = (supportingSlope(upper) - supportingSlope(mirrored)) / 2;
  const within = (/** @type {number} */ drift) => {
    const above = upper.reduce((least, { x, y }) => Math.min(least, y + drift * (0 - x)), Infinity);
    const below = lower.reduce((most, { x, y }) => Math.max(most, y + drift * (0 - x)), -Infinity);
    return { middle: (above + below) / 2, halfWidth: (above - below) / 2 };
  };
  // Jitter tilts the lines, the more the shorter they are: weigh the slope by what it is worth.
  const noise = SLOPE_NOISE * Math.max(0, within(steepest).halfWidth) / Math.max(1, span);
  const drift = Math.min(MAX_DRIFT, Math.max(-MAX_DRIFT, steepest / (1 + (noise / USUAL_DRIFT) ** 2)));
  const { middle, halfWidth } = within(drift);
  return { offset: middle, drift, halfWidth, bound: boundOf(upper, lower, middle) };
}

/**
 * How far `offset` can be off at the origin, whatever the clocks' rates within MAX_DRIFT of one another.
 * @param {Point[]} upper
 * @param {Point[]} lower
 * @param {number} offset
 */
function boundOf(upper, lower, offset) {
  const above = upper.reduce((least, { x, y }) => Math.min(least, y + MAX_DRIFT * Math.abs(x)), Infinity);
  const below = lower.reduce((most, { x, y }) => Math.max(most, y - MAX_DRIFT * Math.abs(x)), -Infinity);
  return Math.max(0, above - offset, offset - below);
}

/**
 * Slope of the highest line below all points, measured at their mean: an edge of the lower convex hull.
 * @param {Point[]} points
 */
function supportingSlope(points) {
  /** @type {(a: Point, b: Point, c: Point) => number} */
  const turn = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  /** @type {Point[]} */
  const hull = [];
  for (const point of [...points].sort((a, b) => a.x - b.x || a.y - b.y)) {
    while (hull.length >= 2 && turn(hull[hull.length - 2], hull[hull.length - 1], point) <= 0) hull.pop();
    hull.push(point);
  }
  const mean = points.reduce((sum, { x }) => sum + x, 0) / points.length;
  const end = hull.findIndex(({ x }, i) => i > 0 && x >= mean && x > hull[i - 1].x);
  return end < 0 ? 0 : (hull[end].y - hull[end - 1].y) / (hull[end].x - hull[end - 1].x);
}

/**
 * To the nearest whole number, halves away from 0.
 * @param {number} x
 */
function round(x) {
  return Math.sign(x) * Math.floor(Math.abs(x) + 0.5);
}
