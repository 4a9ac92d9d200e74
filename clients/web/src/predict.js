// What a row of counts is predicted to be from other frames (PROTOCOL.md section 10), in units of 2^-12 counts, for
// codec 2. Patches repeat: neighbours are looked for around the edges.

import { BETWEEN, TILE } from './frame.js';

/** Taps of a plane. */
export const TAPS = 8;
/** The row that was predicted last. */
export const row = new Int32Array(TILE);
/** Stands in for frames that a prediction does not reach back to. */
export const NOTHING = new Int16Array(TILE * TILE);

/**
 * Row `z` of a plane of a depth above 0.
 * @param {number} depth as in the header
 * @param {Int16Array[]} planes of the three frames before it, the newest first; or of both its neighbours
 * @param {Int16Array} taps
 * @param {number} n
 * @param {number} z
 */
export function predictRow(depth, planes, taps, n, z) {
  const between = depth === BETWEEN, [a, b, c] = planes, last = n - 1;
  const begin = z * n, up = ((z + last) & last) * n, down = ((z + 1) & last) * n;
  const [w0, w1, w2, w3, w4, w5, w6, w7] = taps;
  /** @type {(plane: Int16Array, x: number) => number} */
  const cross = (plane, x) => Math.imul(w0, plane[begin + x]) + Math.imul(w1, plane[begin + ((x + last) & last)])
    + Math.imul(w2, plane[begin + ((x + 1) & last)]) + Math.imul(w3, plane[up + x]) + Math.imul(w4, plane[down + x])
    + (Math.imul(w7, plane[begin + x]) >> 4);
  for (let x = 0; x < n; x++) {
    const others = between ? cross(b, x) : Math.imul(w5, b[begin + x]) + Math.imul(w6, c[begin + x]);
    row[x] = cross(a, x) + others;
  }
}
