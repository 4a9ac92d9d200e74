// What to subscribe to: the wish of the page, fitted to what `hello` offers.

import { subscribeMessage } from './messages.js';

/**
 * @typedef {object} Plan
 * @property {number} rateHz
 * @property {(import('./messages.js').UnitName & {codec: string})[]} units those with a rate of their own come less often
 *   than the others
 */

/**
 * @typedef {object} Wish what a client would like
 * @property {number} rate frames a second: the nearest offered
 * @property {number} level each halves the samples a side; the last of a cascade where it has fewer
 * @property {string} class of errors
 * @property {string} codec
 * @property {string[]} [groups] in order of need: where the server's limits are tight, the last are left out
 */

/** In order of need: a sea without foam is a sea, one without height is not. */
const WANTED = ['displacement', 'slopes', 'derivatives', 'foam'];
/** Codecs that are read here, the usual one first. */
const READ = ['rans', 'i16', 'f16', 'f32'];

/**
 * @param {import('./messages.js').Hello} hello
 * @param {Wish} wish
 * @returns {Plan}
 */
export function planUnits(hello, wish) {
  const rateHz = hello.rates_hz.reduce((a, b) => (Math.abs(b - wish.rate) < Math.abs(a - wish.rate) ? b : a));
  const names = hello.classes.map((c) => c.name);
  const kind = names.includes(wish.class) ? wish.class : names[0];
  const codec = READ.includes(wish.codec) ? wish.codec : READ[0];
  const offered = hello.groups.map((g) => g.name);
  /** @type {Plan['units']} */
  const units = [];
  for (const group of (wish.groups ?? WANTED).filter((g) => offered.includes(g))) {
    for (const cascade of hello.layout.cascades) {
      const most = (cascade.detail ?? []).find((d) => d.group === group);
      if (most?.rate_hz === 0) continue;
      const level = Math.min(Math.max(wish.level, most?.finest_level ?? 0), cascade.levels - 1);
      const slow = most?.rate_hz !== undefined && most.rate_hz < rateHz ? { rate_hz: most.rate_hz } : {};
      units.push({ cascade: cascade.index, level, class: kind, group, codec, ...slow });
    }
  }
  const { units: most = units.length, message_bytes: bytes = Infinity } = hello.limits;
  units.splice(most);
  while (subscribeMessage(Number.MAX_SAFE_INTEGER, rateHz, units).length > bytes) units.pop();
  return { rateHz, units };
}
