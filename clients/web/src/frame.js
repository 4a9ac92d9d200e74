// The header of a binary frame (PROTOCOL.md section 5): every field read, and every wrong one refused.

import { crc32 } from './crc32.js';

export const HEADER_BYTES = 88;
export const CLASSES = ['0.5mm', '1mm', '5mm', '20mm'];
export const GROUPS = [
  'displacement', 'slopes', 'derivatives', 'foam', 'height', 'velocity', 'jacobian', 'stretch', 'normals',
];
export const GROUP_CHANNELS = [3, 2, 3, 1, 1, 3, 2, 2, 2];
export const CODECS = ['i16', 'rans', 'deflate', 'f16', 'f32'];
export const I16 = 0, RANS = 1, DEFLATE = 2, F16 = 3, F32 = 4;
export const FLAG_KEY = 1;
export const FLAG_SATURATED = 2;
/** Ticks between frames of the lowest rate. */
export const SLOWEST_INTERVAL = 480;
/** Frames of the lowest rate that a prediction may reach back to. */
export const MAX_DEPTH = 3;
/** Depth of a frame that is predicted from those on both sides of it. */
export const BETWEEN = 4;
/** Samples a side of the largest tile. */
export const TILE = 256;

const MAGIC = 0x31465753; // "SWF1", little-endian
const MAX_TICK_HIGH = 0x1fffff; // upper half of 2^53 - 1
const TABLES_BYTES = 8192; // beside its samples, a coded frame is never longer

/** A frame that must be dropped; `message` says why. */
export class FrameError extends Error {}

/** A frame that is predicted from one that is not held: its unit must begin anew. */
export class MissingError extends FrameError {}

/** A frame whose header is right and whose payload is not: what follows can't be predicted from it. */
export class PayloadError extends FrameError {}

/**
 * @typedef {object} Frame
 * @property {number} cascade `index` of one of `hello.layout.cascades`
 * @property {number} level
 * @property {number} class index into CLASSES
 * @property {number} group index into GROUPS
 * @property {number} codec index into CODECS
 * @property {number} flags FLAG_KEY, FLAG_SATURATED
 * @property {number} n samples a side of this tile
 * @property {number} levelN samples a side of the whole patch at this level
 * @property {number} tileX
 * @property {number} tileZ
 * @property {number} channels
 * @property {number} depth 0 by itself, 1 to MAX_DEPTH frames of the past, BETWEEN
 * @property {number} tick
 * @property {string} epoch 16 hexadecimal digits
 * @property {bigint} sequence
 * @property {number} layout changes of layout in effect at its tick
 * @property {number} bytes length of the message
 * @property {Float32Array} step metres (or 1) a count, per channel
 * @property {Float32Array} maxError per channel
 */

/**
 * The layer of a tick in time: 0, 1 and 2 come at 15, 30 and 60 Hz; 3 is no frame's.
 * @param {number} tick
 * @returns {number}
 */
export function layerOf(tick) {
  return tick % 480 === 0 ? 0 : tick % 240 === 0 ? 1 : tick % 120 === 0 ? 2 : 3;
}

/**
 * Which sea a message is of, whatever else is wrong with it.
 * @param {ArrayBuffer} buffer
 * @returns {string | null} 16 hexadecimal digits; null where it is too short to tell
 */
export function epochOf(buffer) {
  if (buffer.byteLength < HEADER_BYTES) return null;
  const view = new DataView(buffer, 32, 8);
  return hex32(view.getUint32(4, true)) + hex32(view.getUint32(0, true));
}

/**
 * @param {ArrayBuffer} buffer one whole binary message
 * @returns {Frame}
 * @throws {FrameError}
 */
export function readHeader(buffer) {
  const size = buffer.byteLength;
  if (size < HEADER_BYTES) refuse(`${size} bytes, a header has ${HEADER_BYTES}`);
  const view = new DataView(buffer);
  const u8 = (/** @type {number} */ at) => view.getUint8(at);
  const u16 = (/** @type {number} */ at) => view.getUint16(at, true);
  const u32 = (/** @type {number} */ at) => view.getUint32(at, true);

  if (u32(0) !== MAGIC) refuse('magic is not SWF1');
  if (u16(4) !== HEADER_BYTES) refuse(`header_bytes is ${u16(4)}`);
  const kind = u8(8), group = u8(9), codec = u8(10), flags = u8(11);
  if (kind >= CLASSES.length) refuse(`unknown class ${kind}`);
  if (group >= GROUPS.length) refuse(`unknown group ${group}`);
  if (codec >= CODECS.length) refuse(`unknown codec ${codec}`);
  if (flags & ~(FLAG_KEY | FLAG_SATURATED)) refuse(`unknown flags ${flags}`);

  const n = u16(12), levelN = u16(14), tileX = u16(16), tileZ = u16(18), channels = u16(20);
  if (n < 8 || n > TILE || (n & (n - 1)) !== 0) refuse(`n is ${n}`);
  if (levelN === 0 || levelN % n !== 0) refuse(`level_n is ${levelN}, n is ${n}`);
  if (levelN !== n && n !== TILE) refuse(`a patch of ${levelN} is cut into tiles of ${n}`);
  if (tileX >= levelN / n || tileZ >= levelN / n) refuse(`tile ${tileX}, ${tileZ} lies outside the patch`);
  if (channels !== GROUP_CHANNELS[group]) refuse(`${channels} channels of ${GROUPS[group]}`);
  if (u8(23) !== 0 || u32(84) !== 0) refuse('a zero field is not zero');
  if (u32(28) > MAX_TICK_HIGH) refuse('tick is above 2^53 - 1');
  const tick = u32(28) * 0x100000000 + u32(24), depth = u8(22);
  if ((flags & FLAG_KEY) !== 0 && depth !== 0) refuse(`depth of a key frame is ${depth}`);
  if (!isPossible(depth, codec, tick)) refuse(`depth is ${depth} with ${CODECS[codec]} at tick ${tick}`);

  const step = new Float32Array(buffer, 56, 3);
  const maxError = new Float32Array(buffer, 68, 3);
  for (let c = 0; c < 3; c++) {
    if (c < channels) {
      if (!(step[c] > 0 && step[c] < Infinity)) refuse(`step ${c} is ${step[c]}`);
      const exact = codec === F32; // the field itself
      const wrong = exact ? maxError[c] !== 0 : !(maxError[c] > 0 && maxError[c] < Infinity);
      if (wrong) refuse(`max_error ${c} is ${maxError[c]}`);
    } else if (step[c] !== 0 || maxError[c] !== 0) {
      refuse(`step or max_error of absent channel ${c} is not zero`);
    }
  }

  const payload = u32(52), samples = channels * n * n;
  const fits = { [I16]: payload === samples * 2, [F16]: payload === samples * 2, [F32]: payload === samples * 4 }[codec]
    ?? (payload >= 1 && payload <= samples * 4 + TABLES_BYTES);
  if (!fits) refuse(`payload_bytes is ${payload}`);
  if (size !== HEADER_BYTES + payload) refuse(`${size} bytes, must be ${HEADER_BYTES + payload}`);
  const crc = crc32(crc32(0, buffer, 0, 80), buffer, HEADER_BYTES, payload);
  if (crc !== u32(80)) refuse('crc differs');

  return {
    cascade: u8(6), level: u8(7), class: kind, group, codec, flags, n, levelN, tileX, tileZ, channels, depth, tick,
    epoch: hex32(u32(36)) + hex32(u32(32)),
    sequence: view.getBigUint64(40, true),
    layout: u32(48),
    bytes: size,
    step: step.slice(), maxError: maxError.slice(),
  };
}

/**
 * Frames of a layer are predicted from layers below it alone.
 * @param {number} depth
 * @param {number} codec
 * @param {number} tick
 */
function isPossible(depth, codec, tick) {
  if (depth === 0) return true;
  if (codec !== RANS && codec !== DEFLATE) return false;
  const layer = layerOf(tick);
  return layer === 0 ? depth <= MAX_DEPTH : layer < 3 && depth === BETWEEN;
}

/** @param {number} value */
function hex32(value) {
  return value.toString(16).padStart(8, '0');
}

/**
 * @param {string} why
 * @returns {never}
 */
function refuse(why) {
  throw new FrameError(why);
}
