// The loops over the samples of a coded plane (PROTOCOL.md section 10, codec 1): rANS of four states in turn.
//
// All that a client decodes goes through here, so each kind of plane has a loop of its own over a row, which predicts a
// sample and reads it at once: prediction keeps the multiplier busy, reading waits for memory, and both fit into each
// other. What is done for each sample is written out four times, one for each state. States stay below 2^31: small
// integers.

import { predictAbove, predictRow, row } from './predict.js';

export const SLOT_BITS = 10;
export const SLOTS = 1 << SLOT_BITS;
export const CONTEXTS = 4;
/** The least that a state may be between two samples. */
export const LEAST = 1 << 15;

/** By context and slot: its symbol in the upper 8 bits, the symbol's slots in 12, the slot's place among them in 12. */
export const slots = new Int32Array(CONTEXTS * SLOTS);
/** The four states, then where in the message the next word and the next escape are. */
export const cursor = new Int32Array(6);

const MASK = SLOTS - 1;
/** Bits of a prediction that tell the quarter of a count; as it happens, also where its table begins. */
const QUARTERS = (CONTEXTS - 1) << SLOT_BITS;
/** An entry of `slots` below this is an escape: its symbol is -128. */
const ESCAPES = -127 << 24;

/**
 * Row `z` of a plane that is predicted from frames before it, without low bits.
 * @param {Uint16Array} words the whole message
 * @param {Int16Array} taps
 * @param {Int16Array} a the frame before
 * @param {Int16Array} b the one before that
 * @param {Int16Array} c and the one before that
 * @param {number} n
 * @param {number} z
 * @param {Int16Array} counts filled in
 */
export function readPast(words, taps, a, b, c, n, z, counts) {
  const w0 = taps[0], w1 = taps[1], w2 = taps[2], w3 = taps[3], w4 = taps[4], w5 = taps[5], w6 = taps[6], w7 = taps[7];
  const last = n - 1;
  let x0 = cursor[0], x1 = cursor[1], x2 = cursor[2], x3 = cursor[3], w = cursor[4], e = cursor[5];
  const begin = z * n, next = begin + n, up = ((z + last) & last) * n - begin, down = ((z + 1) & last) * n - begin;
  let west = a[begin + last], here = a[begin], east = 0, p = 0, t = 0;
  for (let i = begin; i < next; i += 4) {
    east = a[i + 1];
    p = Math.imul(w0, here) + Math.imul(w1, west) + Math.imul(w2, east) + Math.imul(w3, a[up + i])
      + Math.imul(w4, a[down + i]) + Math.imul(w5, b[i]) + Math.imul(w6, c[i]) + (Math.imul(w7, here) >> 4) | 0;
    t = slots[p & QUARTERS | x0 & MASK];
    counts[i] = (p >> 12) + (t >> 24);
    x0 = Math.imul(t >> 12 & 0xfff, x0 >> SLOT_BITS) + (t & 0xfff);
    if (x0 < LEAST) x0 = x0 << 16 | words[w++];
    if (t < ESCAPES) counts[i] = words[e++];
    west = here;
    here = east;
    east = a[i + 2];
    p = Math.imul(w0, here) + Math.imul(w1, west) + Math.imul(w2, east) + Math.imul(w3, a[up + i + 1])
      + Math.imul(w4, a[down + i + 1]) + Math.imul(w5, b[i + 1]) + Math.imul(w6, c[i + 1]) + (Math.imul(w7, here) >> 4) | 0;
    t = slots[p & QUARTERS | x1 & MASK];
    counts[i + 1] = (p >> 12) + (t >> 24);
    x1 = Math.imul(t >> 12 & 0xfff, x1 >> SLOT_BITS) + (t & 0xfff);
    if (x1 < LEAST) x1 = x1 << 16 | words[w++];
    if (t < ESCAPES) counts[i + 1] = words[e++];
    west = here;
    here = east;
    east = a[i + 3];
    p = Math.imul(w0, here) + Math.imul(w1, west) + Math.imul(w2, east) + Math.imul(w3, a[up + i + 2])
      + Math.imul(w4, a[down + i + 2]) + Math.imul(w5, b[i + 2]) + Math.imul(w6, c[i + 2]) + (Math.imul(w7, here) >> 4) | 0;
    t = slots[p & QUARTERS | x2 & MASK];
    counts[i + 2] = (p >> 12) + (t >> 24);
    x2 = Math.imul(t >> 12 & 0xfff, x2 >> SLOT_BITS) + (t & 0xfff);
    if (x2 < LEAST) x2 = x2 << 16 | words[w++];
    if (t < ESCAPES) counts[i + 2] = words[e++];
    west = here;
    here = east;
    east = a[i + 4 < next ? i + 4 : begin];
    p = Math.imul(w0, here) + Math.imul(w1, west) + Math.imul(w2, east) + Math.imul(w3, a[up + i + 3])
      + Math.imul(w4, a[down + i + 3]) + Math.imul(w5, b[i + 3]) + Math.imul(w6, c[i + 3]) + (Math.imul(w7, here) >> 4) | 0;
    t = slots[p & QUARTERS | x3 & MASK];
    counts[i + 3] = (p >> 12) + (t >> 24);
    x3 = Math.imul(t >> 12 & 0xfff, x3 >> SLOT_BITS) + (t & 0xfff);
    if (x3 < LEAST) x3 = x3 << 16 | words[w++];
    if (t < ESCAPES) counts[i + 3] = words[e++];
    west = here;
    here = east;
  }
  keep(x0, x1, x2, x3, w, e);
}

/**
 * Row `z` of a plane that is predicted from the frames before and after it, without low bits.
 * @param {Uint16Array} words the whole message
 * @param {Int16Array} taps
 * @param {Int16Array} a
 * @param {Int16Array} b
 * @param {number} n
 * @param {number} z
 * @param {Int16Array} counts filled in
 */
export function readBetween(words, taps, a, b, n, z, counts) {
  const w0 = taps[0], w1 = taps[1], w2 = taps[2], w3 = taps[3], w4 = taps[4], w7 = taps[7];
  const last = n - 1;
  let x0 = cursor[0], x1 = cursor[1], x2 = cursor[2], x3 = cursor[3], w = cursor[4], e = cursor[5];
  const begin = z * n, next = begin + n, up = ((z + last) & last) * n - begin, down = ((z + 1) & last) * n - begin;
  let west = a[begin + last] + b[begin + last], ha = a[begin], hb = b[begin], ea = 0, eb = 0, p = 0, t = 0, j = 0;
  for (let i = begin; i < next; i += 4) {
    ea = a[i + 1];
    eb = b[i + 1];
    p = Math.imul(w0, ha + hb) + Math.imul(w1, west) + Math.imul(w2, ea + eb) + Math.imul(w3, a[up + i] + b[up + i])
      + Math.imul(w4, a[down + i] + b[down + i]) + (Math.imul(w7, ha) >> 4) + (Math.imul(w7, hb) >> 4) | 0;
    t = slots[p & QUARTERS | x0 & MASK];
    counts[i] = (p >> 12) + (t >> 24);
    x0 = Math.imul(t >> 12 & 0xfff, x0 >> SLOT_BITS) + (t & 0xfff);
    if (x0 < LEAST) x0 = x0 << 16 | words[w++];
    if (t < ESCAPES) counts[i] = words[e++];
    west = ha + hb;
    ha = ea;
    hb = eb;
    ea = a[i + 2];
    eb = b[i + 2];
    p = Math.imul(w0, ha + hb) + Math.imul(w1, west) + Math.imul(w2, ea + eb) + Math.imul(w3, a[up + i + 1] + b[up + i + 1])
      + Math.imul(w4, a[down + i + 1] + b[down + i + 1]) + (Math.imul(w7, ha) >> 4) + (Math.imul(w7, hb) >> 4) | 0;
    t = slots[p & QUARTERS | x1 & MASK];
    counts[i + 1] = (p >> 12) + (t >> 24);
    x1 = Math.imul(t >> 12 & 0xfff, x1 >> SLOT_BITS) + (t & 0xfff);
    if (x1 < LEAST) x1 = x1 << 16 | words[w++];
    if (t < ESCAPES) counts[i + 1] = words[e++];
    west = ha + hb;
    ha = ea;
    hb = eb;
    ea = a[i + 3];
    eb = b[i + 3];
    p = Math.imul(w0, ha + hb) + Math.imul(w1, west) + Math.imul(w2, ea + eb) + Math.imul(w3, a[up + i + 2] + b[up + i + 2])
      + Math.imul(w4, a[down + i + 2] + b[down + i + 2]) + (Math.imul(w7, ha) >> 4) + (Math.imul(w7, hb) >> 4) | 0;
    t = slots[p & QUARTERS | x2 & MASK];
    counts[i + 2] = (p >> 12) + (t >> 24);
    x2 = Math.imul(t >> 12 & 0xfff, x2 >> SLOT_BITS) + (t & 0xfff);
    if (x2 < LEAST) x2 = x2 << 16 | words[w++];
    if (t < ESCAPES) counts[i + 2] = words[e++];
    west = ha + hb;
    ha = ea;
    hb = eb;
    j = i + 4 < next ? i + 4 : begin;
    ea = a[j];
    eb = b[j];
    p = Math.imul(w0, ha + hb) + Math.imul(w1, west) + Math.imul(w2, ea + eb) + Math.imul(w3, a[up + i + 3] + b[up + i + 3])
      + Math.imul(w4, a[down + i + 3] + b[down + i + 3]) + (Math.imul(w7, ha) >> 4) + (Math.imul(w7, hb) >> 4) | 0;
    t = slots[p & QUARTERS | x3 & MASK];
    counts[i + 3] = (p >> 12) + (t >> 24);
    x3 = Math.imul(t >> 12 & 0xfff, x3 >> SLOT_BITS) + (t & 0xfff);
    if (x3 < LEAST) x3 = x3 << 16 | words[w++];
    if (t < ESCAPES) counts[i + 3] = words[e++];
    west = ha + hb;
    ha = ea;
    hb = eb;
  }
  keep(x0, x1, x2, x3, w, e);
}

/**
 * Row `z` of a plane that is predicted from its own samples, without low bits.
 * @param {Uint16Array} words the whole message
 * @param {Int16Array} taps
 * @param {number} n
 * @param {number} z
 * @param {Int16Array} counts filled in
 */
export function readSpace(words, taps, n, z, counts) {
  let x0 = cursor[0], x1 = cursor[1], x2 = cursor[2], x3 = cursor[3], w = cursor[4], e = cursor[5];
  predictAbove(taps, counts, n, z);
  const w0 = z === 0 ? 1 << 12 : taps[0], w4 = z === 0 ? 0 : taps[4], w7 = z === 0 ? 0 : taps[7];
  let west = 0, far = 0, p = 0, t = 0;
  for (let x = 0, i = z * n; x < n; x += 4, i += 4) {
    p = row[x] + Math.imul(w4, far) + Math.imul(w0, west) + (Math.imul(w7, west) >> 4) | 0;
    t = slots[p & QUARTERS | x0 & MASK];
    far = west;
    west = (p >> 12) + (t >> 24);
    x0 = Math.imul(t >> 12 & 0xfff, x0 >> SLOT_BITS) + (t & 0xfff);
    if (x0 < LEAST) x0 = x0 << 16 | words[w++];
    if (t < ESCAPES) west = words[e++];
    if ((west + 32768 & -65536) !== 0) west = west << 16 >> 16;
    counts[i] = west;
    if (x === 0) far = west;
    p = row[x + 1] + Math.imul(w4, far) + Math.imul(w0, west) + (Math.imul(w7, west) >> 4) | 0;
    t = slots[p & QUARTERS | x1 & MASK];
    far = west;
    west = (p >> 12) + (t >> 24);
    x1 = Math.imul(t >> 12 & 0xfff, x1 >> SLOT_BITS) + (t & 0xfff);
    if (x1 < LEAST) x1 = x1 << 16 | words[w++];
    if (t < ESCAPES) west = words[e++];
    if ((west + 32768 & -65536) !== 0) west = west << 16 >> 16;
    counts[i + 1] = west;
    p = row[x + 2] + Math.imul(w4, far) + Math.imul(w0, west) + (Math.imul(w7, west) >> 4) | 0;
    t = slots[p & QUARTERS | x2 & MASK];
    far = west;
    west = (p >> 12) + (t >> 24);
    x2 = Math.imul(t >> 12 & 0xfff, x2 >> SLOT_BITS) + (t & 0xfff);
    if (x2 < LEAST) x2 = x2 << 16 | words[w++];
    if (t < ESCAPES) west = words[e++];
    if ((west + 32768 & -65536) !== 0) west = west << 16 >> 16;
    counts[i + 2] = west;
    p = row[x + 3] + Math.imul(w4, far) + Math.imul(w0, west) + (Math.imul(w7, west) >> 4) | 0;
    t = slots[p & QUARTERS | x3 & MASK];
    far = west;
    west = (p >> 12) + (t >> 24);
    x3 = Math.imul(t >> 12 & 0xfff, x3 >> SLOT_BITS) + (t & 0xfff);
    if (x3 < LEAST) x3 = x3 << 16 | words[w++];
    if (t < ESCAPES) west = words[e++];
    if ((west + 32768 & -65536) !== 0) west = west << 16 >> 16;
    counts[i + 3] = west;
  }
  keep(x0, x1, x2, x3, w, e);
}

/**
 * Row `z` of any plane of one context, with low bits or without.
 * @param {Uint16Array} words the whole message
 * @param {number} shift
 * @param {number} depth as in the header
 * @param {Int16Array[]} planes what it is predicted from
 * @param {Int16Array} taps
 * @param {number} n
 * @param {number} z
 * @param {Int16Array} counts filled in
 */
export function readShifted(words, shift, depth, planes, taps, n, z, counts) {
  const lowBits = (1 << shift) - 1;
  let w = cursor[4], e = cursor[5];
  if (depth === 0) predictAbove(taps, counts, n, z);
  else predictRow(depth, planes, taps, n, z);
  const inSpace = depth === 0, first = z === 0;
  const w0 = !inSpace ? 0 : first ? 1 << 12 : taps[0];
  const w4 = inSpace && !first ? taps[4] : 0, w7 = inSpace && !first ? taps[7] : 0;
  for (let x = 0, i = z * n, west = 0, far = 0; x < n; x++, i++) {
    const p = row[x] + Math.imul(w4, far) + Math.imul(w0, west) + (Math.imul(w7, west) >> 4) | 0;
    let state = cursor[x & 3];
    const t = slots[state & MASK];
    state = Math.imul(t >> 12 & 0xfff, state >> SLOT_BITS) + (t & 0xfff);
    if (state < LEAST) state = state << 16 | words[w++];
    counts[i] = (p >> 12) + (t >> 24 << shift) + (state & lowBits);
    state >>= shift;
    if (state < LEAST) state = state << 16 | words[w++];
    if (t < ESCAPES) counts[i] = words[e++];
    cursor[x & 3] = state;
    far = x === 0 ? counts[i] : west;
    west = counts[i];
  }
  cursor[4] = w;
  cursor[5] = e;
}

/**
 * Writes `cursor` back.
 * @param {number} x0
 * @param {number} x1
 * @param {number} x2
 * @param {number} x3
 * @param {number} w
 * @param {number} e
 */
function keep(x0, x1, x2, x3, w, e) {
  cursor[0] = x0;
  cursor[1] = x1;
  cursor[2] = x2;
  cursor[3] = x3;
  cursor[4] = w;
  cursor[5] = e;
}
