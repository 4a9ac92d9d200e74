// Text messages (PROTOCOL.md sections 3 and 4): reads the server's, writes the client's.

export const SUBPROTOCOL = 'swellcast.v1';
export const TICKS_PER_SECOND = 7200;
/** A cascade that ends is zero for this long before its last tick. */
export const REST_TICKS = 1440;

// Fields are as the protocol has them. Checked are those in FORMS alone: without the others this client can do.

/**
 * @typedef {object} Cascade
 * @property {number} index
 * @property {number} patch_m
 * @property {number} n samples a side
 * @property {number} levels
 * @property {number} wavelength_min_m
 * @property {number} wavelength_max_m
 * @property {number} from_tick
 * @property {number | null} until_tick null while no change of layout ends it
 * @property {{group: string, finest_level: number, rate_hz?: number}[]} [detail] what there is of it, where that is not all
 */

/** @typedef {{cascade: number, level: number, class: string, group: string, codec?: string, rate_hz?: number}} UnitName */
/** @typedef {{name: string, displacement_m: number, slope: number, foam: number, velocity_mps: number}} ErrorClass */

/**
 * @typedef {object} Hello
 * @property {'hello'} type
 * @property {number} protocol
 * @property {string} server
 * @property {string} scene
 * @property {string} epoch
 * @property {string} seed
 * @property {number} ticks_per_second
 * @property {number} tick
 * @property {number} lead_ticks
 * @property {number} sequence
 * @property {{generation: number, cascades: Cascade[]}} layout
 * @property {number} choppiness
 * @property {number[]} rates_hz
 * @property {ErrorClass[]} classes
 * @property {{name: string, channels: string[]}[]} groups
 * @property {number} foam_step_ticks
 * @property {{message_bytes: number, units: number, live_units: number, points?: number}} limits
 */

/**
 * @typedef {object} Status
 * @property {'status'} type
 * @property {number} tick
 * @property {number} sequence
 * @property {number} hs_m
 * @property {{speed_mps: number, direction_from_deg: number} | null} wind
 * @property {[number, number] | null} wind_range_mps
 * @property {number | null} depth_m
 * @property {number} clients
 * @property {string} backend
 * @property {number} step_ms
 * @property {number} skipped_frames
 */

/**
 * @typedef {object} LayoutChange
 * @property {'layout'} kind
 * @property {number} [n]
 * @property {number} band_limit
 * @property {number} finest_wavelength_m
 * @property {number[]} patches_m
 * @property {[number, number]} [wind_range_mps]
 */

/**
 * @typedef {object} Change
 * @property {'change'} type
 * @property {number} sequence
 * @property {number} effective_tick
 * @property {number} transition_ticks
 * @property {{kind: 'wind', speed_mps: number, direction_from_deg: number}
 *   | {kind: 'water', depth_m?: number | null, gravity?: number} | LayoutChange} change
 */

/** @typedef {{type: 'subscribed', id: number, rate_hz: number, units: UnitName[], from_tick: number}} Subscribed */
/** @typedef {{type: 'points_subscribed', id: number, rate_hz: number, from_tick: number, count: number}} PointsSubscribed */
/** @typedef {{type: 'time', t0: number, t1_us: number, t2_us: number}} Time */
/** @typedef {{type: 'quality', rate_hz: number, coarser: number}} Quality */
/** @typedef {{type: 'error', code: string, detail: string, field?: string, id?: number}} Refusal */
/** @typedef {Hello | PointsSubscribed | Subscribed | Time | Quality | Status | Change | Refusal} Message */

/** A text message that can't be used; `message` says why. */
export class MessageError extends Error {}

/** @typedef {(v: any) => boolean} Check of something that was parsed, whatever it is */

/** @type {Check} */
const finite = Number.isFinite;
/** @type {Check} */
const index = (v) => Number.isSafeInteger(v) && v >= 0;
/** @type {Check} */
const text = (v) => typeof v === 'string';
/** @type {Check} */
const list = Array.isArray;
/** @type {Check} */
const object = (v) => v !== null && typeof v === 'object' && !list(v);
/** @type {(check: Check) => Check} */
const orNull = (check) => (v) => v === null || check(v);
/** @type {(check: Check) => Check} */
const orAbsent = (check) => (v) => v === undefined || check(v);
/** @type {Check} */
const isWind = (v) => object(v) && finite(v.speed_mps) && finite(v.direction_from_deg);
/** @type {Check} */
const isUnit = (v) => object(v) && index(v.cascade) && index(v.level) && text(v.class) && text(v.group)
  && orAbsent(text)(v.codec) && orAbsent(index)(v.rate_hz);
/** @type {Check} */
const isDetail = (v) => object(v) && text(v.group) && orAbsent(index)(v.finest_level) && orAbsent(index)(v.rate_hz);
/** @type {Check} */
const isDetails = (v) => list(v) && v.every(isDetail);
/** @type {Check} */
const isCascade = (v) => object(v) && index(v.index) && index(v.from_tick) && orNull(index)(v.until_tick)
  && v.patch_m > 0 && v.patch_m < Infinity && index(v.n) && v.n > 0
  && index(v.levels) && v.levels > 0 && orAbsent(isDetails)(v.detail)
  && v.wavelength_min_m > 0 && v.wavelength_max_m > 0;

/** @type {Check} */
const isRate = (v) => index(v) && v > 0;
/** @type {Check} */
const isNamed = (v) => object(v) && text(v.name);
/** @type {Check} */
const isGroup = (v) => isNamed(v) && list(v.channels);

/**
 * What each message must hold for this client to use it; other fields are ignored.
 * @type {Record<Message['type'], Record<string, Check>>}
 */
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
    rates_hz: (v) => list(v) && v.length > 0 && v.every(isRate),
    classes: (v) => list(v) && v.every(isNamed),
    groups: (v) => list(v) && v.every(isGroup),
    limits: object,
  },
  points_subscribed: { id: index, rate_hz: index, from_tick: index, count: index },
  subscribed: { id: index, rate_hz: index, units: (v) => list(v) && v.every(isUnit), from_tick: index },
  time: { t0: finite, t1_us: finite, t2_us: finite },
  quality: { rate_hz: isRate, coarser: index },
  status: { tick: index, sequence: index, hs_m: finite, wind: orNull(isWind) },
  change: { sequence: index, effective_tick: index, transition_ticks: index, change: object },
  error: { code: text, detail: text },
};

/**
 * @param {Cascade} cascade
 * @param {number} tick
 * @returns {boolean} whether it is part of the sea then
 */
export function isThere(cascade, tick) {
  return tick >= cascade.from_tick && (cascade.until_tick === null || tick < cascade.until_tick);
}

/**
 * @param {string} json
 * @returns {Message | null} null for a type this client doesn't know
 * @throws {MessageError}
 */
export function parseServerMessage(json) {
  /** @type {any} what it is, is seen below */
  let message;
  try {
    message = JSON.parse(json);
  } catch (error) {
    throw new MessageError(`not JSON: ${/** @type {Error} */ (error).message}`);
  }
  if (!object(message) || !text(message.type)) throw new MessageError('not an object with a type');
  if (!Object.hasOwn(FORMS, message.type)) return null;
  for (const [field, holds] of Object.entries(FORMS[/** @type {Message['type']} */ (message.type)])) {
    if (!holds(message[field])) {
      throw new MessageError(`${message.type}.${field} is ${JSON.stringify(message[field])}`);
    }
  }
  return message;
}

/**
 * @param {number} id
 * @param {number} rateHz
 * @param {UnitName[]} units
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
 * @param {import('./fares.js').Report} report
 * @param {boolean} lost a frame could not be read: all units begin again
 * @returns {string}
 */
export function reportMessage(report, lost) {
  return JSON.stringify({ type: 'report', ...report, ...(lost ? { lost } : {}) });
}
