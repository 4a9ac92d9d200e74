// Reads a coded plane (PROTOCOL.md section 10, codec 1): its head, its tables, and that it ends where it should.

import { BETWEEN, FrameError } from './frame.js';
import { CONTEXTS, cursor, LEAST, readBetween, readPast, readShifted, readSpace, SLOTS, slots } from './lanes.js';

const MOST_SHIFT = 8;
const HEAD_BYTES = 28;

/**
 * Reads a plane of n x n counts.
 * @param {DataView} view of the whole message
 * @param {Uint16Array} words the whole message, but for an odd last byte
 * @param {number} at where the plane begins, a multiple of 4
 * @param {number} depth as in the header
 * @param {Int16Array[]} planes what it is predicted from: three, or two neighbours; none at depth 0
 * @param {Int16Array} taps
 * @param {number} n
 * @param {Int16Array} counts filled in; of no use after an error
 * @returns {number} where it ends
 * @throws {FrameError}
 */
export function readPlane(view, words, at, depth, planes, taps, n, counts) {
  const end = view.byteLength;
  if (end - at < HEAD_BYTES) damaged('too short');
  const contexts = view.getUint8(at), shift = view.getUint8(at + 1), tables = view.getUint16(at + 2, true);
  const wordCount = view.getUint32(at + 4, true), escapeCount = view.getUint32(at + 8, true);
  if ((contexts !== 1 && contexts !== CONTEXTS) || shift > MOST_SHIFT || (shift > 0 && contexts > 1) || tables % 2 === 1) {
    damaged("a plane's head");
  }
  if (wordCount > 2 * n * n || escapeCount > n * n) damaged('more than the samples can take');
  const tablesBegin = at + HEAD_BYTES, tablesEnd = tablesBegin + tables, used = tablesEnd + 2 * (wordCount + escapeCount);
  const after = Math.ceil(used / 4) * 4;
  if (after > end) damaged('too short');
  for (let i = used; i < after; i++) if (view.getUint8(i) !== 0) damaged('padding');
  readTables(view, tablesBegin, tablesEnd, contexts);
  for (let lane = 0; lane < 4; lane++) {
    const state = view.getUint32(at + 12 + 4 * lane, true);
    if (state < LEAST || state >= 2 ** 31) damaged('a state');
    cursor[lane] = state;
  }
  const firstWord = tablesEnd / 2, firstEscape = firstWord + wordCount;
  cursor[4] = firstWord;
  cursor[5] = firstEscape;
  for (let z = 0; z < n; z++) {
    if (shift > 0) readShifted(words, shift, depth, planes, taps, n, z, counts);
    else if (depth === 0) readSpace(words, taps, n, z, counts);
    else if (depth === BETWEEN) readBetween(words, taps, planes[0], planes[1], n, z, counts);
    else readPast(words, taps, planes[0], planes[1], planes[2], n, z, counts);
  }
  // An encoder begins with the least state, so that is where a whole plane ends. Who read too much is further on.
  const whole = cursor[4] === firstEscape && cursor[5] === used / 2;
  if (!whole || cursor.subarray(0, 4).some((state) => state !== LEAST)) damaged('a plane does not end where it should');
  return after;
}

/**
 * Fills in the tables of all contexts; a plane of one context has that one in place of each.
 * @param {DataView} view
 * @param {number} begin
 * @param {number} end
 * @param {number} contexts
 */
function readTables(view, begin, end, contexts) {
  let left = begin;
  for (let context = 0; context < contexts; context++) left = readTable(view, left, end, context * SLOTS);
  if (end - left > 1 || (left < end && view.getUint8(left) !== 0)) damaged('bytes after the tables');
  for (let context = contexts; context < CONTEXTS; context++) slots.copyWithin(context * SLOTS, 0, SLOTS);
}

/**
 * Fills in one table.
 * @param {DataView} view
 * @param {number} begin
 * @param {number} end of all tables
 * @param {number} slot its first
 * @returns {number} where it ends
 */
function readTable(view, begin, end, slot) {
  let at = begin;
  const byte = () => {
    if (at >= end) damaged('a table ends early');
    return view.getUint8(at++);
  };
  const first = byte(), more = byte();
  let filled = 0;
  for (let symbol = first; symbol <= first + more; symbol++) {
    let share = byte();
    if (share >= 128) share = share & 127 | byte() << 7;
    if (symbol > 255 || filled + share > SLOTS) damaged('a table with too much in it');
    const entry = (symbol ^ 0x80) << 24 | share << 12;
    for (let place = 0; place < share; place++) slots[slot + filled + place] = entry | place;
    filled += share;
  }
  if (filled !== SLOTS) damaged('a table with too little in it');
  return at;
}

/**
 * @param {string} what
 * @returns {never}
 */
function damaged(what) {
  throw new FrameError(`payload: ${what}`);
}
