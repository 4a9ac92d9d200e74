// Text messages (PROTOCOL.md sections 3 and 4): reads the server's, writes the client's.

export const SUBPROTOCOL = 'swellcast.v1';
export const TICKS_PER_SECOND = 7200;
/** A cascade that ends is zero for this long before its last tick. */
export const REST_TICKS = 1440;

/** A text message that can't be used; `message` says why. */
export class MessageError extends Error {}

const finite = Number.isFinite;
const index = (v) => Number.isSafeInteger(v) && v >= 0;
const text = (v) => typeof v === 'string';
const list = Array.isArray;
const object = (v) => v !== null && typeof v === 'object' && !list(v);
const orNull = (check) => (v) => v === null || check(v);
const orAbsent = (check) => (v) => v === undefined || check(v);
const isWind = (v) => object(v) && finite(v.speed_mps) && finite(v.direction_from_deg);
const isUnit = (v) => object(v) && index(v.cascade) && index(v.level) && text(v.class) && text(v.group)
  && orAbsent(text)(v.codec) && orAbsent(index)(v.rate_hz);
const isCascade = (v) => object(v) && index(v.index) && index(v.from_tick) && orNull(index)(v.until_tick) && v.patch_m > 0 && v.patch_m < Infinity && index(v.n) && v.n > 0
  && index(v.levels) && v.wavelength_min_m > 0 && v.wavelength_max_m > 0;

/** What each message must hold for this client to use it; other fields are ignored. */
const FORMS = {
  hello: {
    protocol: (v) => v === 1,
    scene: text,
    epoch: (v) => text(v) && /^[0-9a-f]{16}$/i.test(v),
    ticks_per_second: (v) => v === TICKS_PER_SECOND,
    tick: index,
    lead_ticks: index,
    sequence: index,
    layout: (v) => object(v) && index(v.generation) && list(v.cascades) && v.cascades.every(isCascade),
    rates_hz: (v) => list(v) && v.length > 0 && v.every((r) => index(r) && r > 0),
    classes: (v) => list(v) && v.every((c) => object(c) && text(c.name)),
    groups: (v) => list(v) && v.every((g) => object(g) && text(g.name) && list(g.channels)),
    limits: object,
  },
  points_subscribed: { id: index, rate_hz: index, from_tick: index, count: index },
  subscribed: { id: index, rate_hz: index, units: (v) => list(v) && v.every(isUnit), from_tick: index },
  time: { t0: finite, t1_us: finite, t2_us: finite },
  quality: { rate_hz: (v) => index(v) && v > 0, coarser: index },
  status: { tick: index, sequence: index, hs_m: finite, wind: orNull(isWind) },
  change: { sequence: index, effective_tick: index, transition_ticks: index, change: object },
  error: { code: text, detail: text },
};

/**
 * @param {object} cascade of `hello`
 * @param {number} tick
 * @returns {boolean} whether it is part of the sea then
 */
export function isThere(cascade, tick) {
  return tick >= cascade.from_tick && (cascade.until_tick === null || tick < cascade.until_tick);
}

/**
 * @param {string} json
 * @returns {object | null} null for a type this client doesn't know
 * @throws {MessageError}
 */
export function parseServerMessage(json) {
  let message;
  try {
    message = JSON.parse(json);
  } catch (error) {
    throw new MessageError(`not JSON: ${error.message}`);
  }
  if (!object(message) || !text(message.type)) throw new MessageError('not an object with a type');
  if (!Object.hasOwn(FORMS, message.type)) return null;
  for (const [field, holds] of Object.entries(FORMS[message.type])) {
    if (!holds(message[field])) {
      throw new MessageError(`${message.type}.${field} is ${JSON.stringify(message[field])}`);
    }
  }
  return message;
}

/**
 * @param {number} id
 * @param {number} rateHz
 * @param {{cascade: number, level: number, class: string, group: string, codec?: string, rate_hz?: number}[]} units
 * @returns {string}
 */
export function subscribeMessage(id, rateHz, units) {
  return JSON.stringify({ type: 'subscribe', id, rate_hz: rateHz, units });
}

/**
 * @param {number} t0 own monotonic time
 * @returns {string}
 */
export function timeMessage(t0) {
  return JSON.stringify({ type: 'time', t0 });
}

/**
 * @param {{tick: number, decode_ms: number, buffer_ms: number}} report
 * @param {boolean} lost a frame could not be read: all units begin again
 * @returns {string}
 */
export function reportMessage(report, lost) {
  return JSON.stringify({ type: 'report', ...report, ...(lost ? { lost } : {}) });
}
