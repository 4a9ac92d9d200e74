// Counts from the residuals of codec 2 (PROTOCOL.md section 10). Inflating is whoever's who uses it: browsers inflate
// only in their own time, so this client asks for codec 1, and Node has zlib.

import { PayloadError } from './frame.js';
import { predictRow, row } from './predict.js';

/**
 * Fills in the counts of a plane.
 * @param {Uint8Array} low
 * @param {Uint8Array | null} high
 * @param {number} depth as in the header
 * @param {Int16Array[]} planes what it is predicted from; none at depth 0
 * @param {Int16Array} taps
 * @param {number} n
 * @param {Int16Array} counts filled in
 */
export function restorePlane(low, high, depth, planes, taps, n, counts) {
  for (let z = 0, i = 0; z < n; z++) {
    if (depth > 0) predictRow(depth, planes, taps, n, z);
    for (let x = 0; x < n; x++, i++) {
      const folded = high ? low[i] | high[i] << 8 : low[i];
      counts[i] = (depth > 0 ? (row[x] + 2048 | 0) >> 12 : around(counts, n, x, z, i)) + (folded >> 1 ^ -(folded & 1));
    }
  }
}

/**
 * West + north - north-west, what lies outside being 0.
 * @param {Int16Array} counts
 * @param {number} n
 * @param {number} x
 * @param {number} z
 * @param {number} i
 */
function around(counts, n, x, z, i) {
  const west = x > 0 ? counts[i - 1] : 0, north = z > 0 ? counts[i - n] : 0;
  return west + north - (x > 0 && z > 0 ? counts[i - n - 1] : 0);
}

/**
 * @param {(bytes: Uint8Array, most: number) => Uint8Array} inflate throws where it can't
 * @param {Uint8Array} stream
 * @param {number} size
 * @returns {Uint8Array} exactly so many bytes
 * @throws {PayloadError}
 */
export function inflated(inflate, stream, size) {
  let bytes;
  try {
    bytes = inflate(stream, size);
  } catch (error) {
    throw new PayloadError(`payload: no deflate stream: ${/** @type {Error} */ (error).message}`);
  }
  if (bytes.length !== size) throw new PayloadError(`payload: ${bytes.length} bytes of residuals, must be ${size}`);
  return bytes;
}
