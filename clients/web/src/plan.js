// What to subscribe to: the wish of the page, fitted to what `hello` offers.

import { subscribeMessage } from './messages.js';

/**
 * @typedef {object} Plan
 * @property {number} rateHz
 * @property {{cascade: number, level: number, class: string, group: string, codec: string, rate_hz?: number}[]} units those
 *   with a rate of their own come less often than the others
 */

/** In order of need: a sea without foam is a sea, one without height is not. */
const WANTED = ['displacement', 'slopes', 'derivatives', 'foam'];
/** Codecs whose frames are counts and that a browser can read, the usual one first. */
const READ = ['rans', 'i16'];

/**
 * @param {object} hello
 * @param {{rate: number, level: number, class: string, codec: string}} wish
 * @returns {Plan}
 */
export function planUnits(hello, wish) {
  const rateHz = hello.rates_hz.reduce((a, b) => (Math.abs(b - wish.rate) < Math.abs(a - wish.rate) ? b : a));
  const names = hello.classes.map((c) => c.name);
  const kind = names.includes(wish.class) ? wish.class : names[0];
  const codec = READ.includes(wish.codec) ? wish.codec : READ[0];
  const offered = hello.groups.map((g) => g.name);
  const units = [];
  for (const group of WANTED.filter((g) => offered.includes(g))) {
    for (const cascade of hello.layout.cascades) {
      const most = (cascade.detail ?? []).find((d) => d.group === group);
      if (most?.rate_hz === 0) continue;
      const level = Math.min(Math.max(wish.level, most?.finest_level ?? 0), cascade.levels - 1);
      const slow = most?.rate_hz < rateHz ? { rate_hz: most.rate_hz } : {};
      units.push({ cascade: cascade.index, level, class: kind, group, codec, ...slow });
    }
  }
  const { units: most = units.length, message_bytes: bytes = Infinity } = hello.limits;
  units.splice(most);
  while (subscribeMessage(Number.MAX_SAFE_INTEGER, rateHz, units).length > bytes) units.pop();
  return { rateHz, units };
}
