// What a row of counts is predicted to be (PROTOCOL.md section 10), in units of 2^-12 counts, for planes of which
// `lanes.js` has no loop of its own. Patches repeat: neighbours are looked for around the edges.

import { BETWEEN } from './frame.js';

/** Taps of a plane. */
export const TAPS = 8;
/** Samples a side of the largest tile. */
const TILE = 256;
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

/**
 * What the rows above say of row `z` of the plane itself, without what its own row adds: all of it for the first
 * column, nothing in the first row.
 * @param {Int16Array} taps
 * @param {Int16Array} plane
 * @param {number} n
 * @param {number} z
 */
export function predictAbove(taps, plane, n, z) {
  if (z === 0) {
    row.fill(0);
    return;
  }
  const w1 = taps[1], w2 = taps[2], w3 = taps[3], w5 = taps[5];
  const last = n - 1, up = (z - 1) * n, far = z > 1 ? up - n : up;
  let northWest = plane[up], north = plane[up + 1];
  row[0] = northWest << 12;
  for (let x = 1; x < last; x++) {
    const northEast = plane[up + x + 1];
    row[x] = Math.imul(w1, north) + Math.imul(w2, northWest) + Math.imul(w3, northEast) + Math.imul(w5, plane[far + x]);
    northWest = north;
    north = northEast;
  }
  row[last] = Math.imul(w1, north) + Math.imul(w2, northWest) + Math.imul(w3, north) + Math.imul(w5, plane[far + last]);
}
