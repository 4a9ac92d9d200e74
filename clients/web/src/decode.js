// Frames back to counts (PROTOCOL.md sections 5 and 10), in the order in which they came.
// Invariant: a frame that is wrong in any way is refused as a whole, and what was decoded before stands.

import { inflated, restorePlane } from './deflate.js';
import {
  DEFLATE, F16, F32, HEADER_BYTES, I16, layerOf, MissingError, PayloadError, RANS, readHeader, TILE,
} from './frame.js';
import { History } from './history.js';
import { Kernels } from './kernels.js';
import { NOTHING, TAPS } from './predict.js';

/** Of each length: all units of a tick and a few more. */
const MOST_SPARE = 32;
const MOST_LENGTHS = 16;
const MOST_COUNTS = 3 * TILE * TILE;
const TAPS_BYTES = 2 * TAPS + 4;

/**
 * @typedef {import('./frame.js').Frame & {counts: Int16Array | null, floats: Float32Array | null}} DecodedFrame all planes,
 *   one after the other: counts, or floats with the codecs that have no counts. With codec `i16` a view into the message
 */

/** @typedef {import('./frame.js').Frame} Frame */
/** @typedef {import('./history.js').Kept} Kept */
/** @typedef {Pick<Frame, 'cascade' | 'level' | 'class' | 'group' | 'codec'>} UnitKey */
/** @typedef {UnitKey & {tiles: Map<number, History>}} UnitHistory */

/** @type {{kernels: Kernels, scratch: number} | undefined} of all decoders of a thread; `scratch`: counts of a largest frame */
let shared;

/** Bounded: what is kept for predictions is four frames of a tile, of no more samples in all than it was made for. */
export class Decoder {
  /**
   * @param {number} mostSamples of all units at one tick
   * @param {((bytes: Uint8Array, most: number) => Uint8Array) | null} inflate for codec `deflate`
   */
  constructor(mostSamples, inflate = null) {
    this.mostSamples = mostSamples;
    this.inflate = inflate;
    /** @type {Map<number, UnitHistory>} */
    this.units = new Map();
    this.taps = [0, 1, 2].map(() => new Int16Array(TAPS));
    if (!shared) {
      const kernels = new Kernels();
      shared = { kernels, scratch: kernels.exports.take_counts(MOST_COUNTS) };
    }
    this.kernels = shared.kernels;
    this.scratch = shared.scratch;
    /** @type {Map<number, ArrayBuffer[]>} by length: memory of counts that nobody needs any more */
    this.spare = new Map();
  }

  /**
   * Takes back the memory of a frame's counts, for frames to come: so much comes each second that collecting it would
   * hold up pictures.
   * @param {ArrayBuffer} buffer of nothing else
   */
  recycle(buffer) {
    const { byteLength } = buffer, held = this.spare.get(byteLength);
    if (!held && this.spare.size < MOST_LENGTHS) this.spare.set(byteLength, [buffer]);
    else if (held && held.length < MOST_SPARE) held.push(buffer);
  }

  /**
   * Forgets the frames of units that are not wanted any more. Who needs a decoder no longer wants none.
   * @param {(unit: UnitKey) => boolean} wanted
   */
  retain(wanted) {
    for (const [key, unit] of this.units) {
      if (wanted(unit)) continue;
      unit.tiles.forEach((history) => history.dispose());
      this.units.delete(key);
    }
  }

  /**
   * @param {ArrayBuffer} buffer one whole binary message
   * @returns {DecodedFrame}
   * @throws {import('./frame.js').FrameError}
   */
  decode(buffer) {
    const frame = /** @type {DecodedFrame} */ (readHeader(buffer));
    const { codec, channels, n } = frame;
    const samples = channels * n * n;
    frame.counts = frame.floats = null;
    if (codec === I16) frame.counts = new Int16Array(buffer, HEADER_BYTES, samples);
    else if (codec === F16) frame.floats = Float32Array.from(new Uint16Array(buffer, HEADER_BYTES, samples), fromHalf);
    else if (codec === F32) frame.floats = new Float32Array(buffer, HEADER_BYTES, samples);
    else this.#predicted(frame, buffer);
    if (frame.floats?.some((value) => !Number.isFinite(value))) {
      throw new PayloadError('payload: a value that is not finite');
    }
    return frame;
  }

  /** @param {DecodedFrame} frame @param {ArrayBuffer} buffer */
  #predicted(frame, buffer) {
    const { codec, tick, depth, channels, n } = frame;
    const history = this.#history(frame), basis = depth === 0 ? [] : history?.basis(tick, depth);
    if (!basis) throw new MissingError(`predicted from a frame that is not held: depth ${depth} at tick ${tick}`);
    const spare = this.spare.get(2 * channels * n * n)?.pop();
    const counts = frame.counts = spare ? new Int16Array(spare) : new Int16Array(channels * n * n);
    if (codec === RANS) this.#rans(frame, buffer, basis, counts);
    else this.#deflate(frame, buffer, basis, counts);
    if (layerOf(tick) < 2) this.#keep(frame, history, counts);
  }

  /** @param {Frame} frame @param {ArrayBuffer} buffer @param {Kept[]} basis @param {Int16Array} counts */
  #rans({ depth, channels, n }, buffer, [a, b, c], counts) {
    const { kernels, scratch } = this, { read_plane: readPlane } = kernels.exports;
    kernels.hold(new Uint8Array(buffer, HEADER_BYTES));
    let at = 0;
    for (let channel = 0; channel < channels; channel++) {
      const taken = readPlane(at, depth, channel, n, scratch, a?.name ?? 0, b?.name ?? 0, c?.name ?? 0);
      if (taken < 0) throw new PayloadError(`payload: ${kernels.fault()}`);
      at += taken;
    }
    if (at !== buffer.byteLength - HEADER_BYTES) throw new PayloadError('payload: bytes after the last plane');
    counts.set(kernels.counts(scratch, 0, counts.length));
  }

  /** @param {Frame} frame @param {ArrayBuffer} buffer @param {Kept[]} basis @param {Int16Array} counts */
  #deflate({ depth, channels, n }, buffer, basis, counts) {
    if (!this.inflate) throw new PayloadError('codec deflate is not read here');
    const view = new DataView(buffer), samples = n * n, wide = [];
    for (let c = 0; c < channels; c++) wide.push(readTaps(view, HEADER_BYTES + c * TAPS_BYTES, this.taps[c]));
    if (depth === 0 && this.taps.slice(0, channels).some((taps) => taps.some((tap) => tap !== 0))) {
      throw new PayloadError('payload: taps where they are fixed');
    }
    const size = samples * (channels + wide.filter(Boolean).length);
    const bytes = inflated(this.inflate, new Uint8Array(buffer, HEADER_BYTES + channels * TAPS_BYTES), size);
    let at = 0;
    const take = () => bytes.subarray(at, at += samples);
    for (let c = 0; c < channels; c++) {
      const low = take(), high = wide[c] ? take() : null;
      const planes = [0, 1, 2].map((i) => (basis[i] ? this.kernels.counts(basis[i].name, c * samples, samples) : NOTHING));
      restorePlane(low, high, depth, planes, this.taps[c], n, counts.subarray(c * samples, (c + 1) * samples));
    }
  }

  /**
   * What is held of the frame's tile, if it is of the same sea and size.
   * @param {Frame} frame
   */
  #history({ epoch, channels, n, tileX, tileZ, ...unit }) {
    const held = this.units.get(keyOf(unit))?.tiles.get(tileX * 65536 + tileZ);
    return held && held.epoch === epoch && held.channels === channels && held.samples === n * n ? held : null;
  }

  /** @param {Frame} frame @param {History | null} held @param {Int16Array} counts */
  #keep(frame, held, counts) {
    const { cascade, level, class: kind, group, codec, epoch, channels, n, tileX, tileZ } = frame;
    const key = keyOf(frame), tile = tileX * 65536 + tileZ;
    let history = held;
    if (!history) {
      let unit = this.units.get(key);
      unit?.tiles.get(tile)?.dispose();
      unit?.tiles.delete(tile);
      // More than was asked for: what comes of it can't be predicted from.
      if (this.#samples() + channels * n * n > this.mostSamples) return;
      if (!unit) this.units.set(key, unit = { cascade, level, class: kind, group, codec, tiles: new Map() });
      history = new History(this.kernels, epoch, channels, n * n);
      unit.tiles.set(tile, history);
    }
    history.keep(frame.tick, counts);
  }

  #samples() {
    let sum = 0;
    for (const { tiles } of this.units.values()) {
      for (const { channels, samples } of tiles.values()) sum += channels * samples;
    }
    return sum;
  }
}

/**
 * Reads a frame that stands by itself.
 * @param {ArrayBuffer} buffer
 * @returns {DecodedFrame}
 * @throws {import('./frame.js').FrameError}
 */
export function decodeFrame(buffer) {
  return new Decoder(0).decode(buffer);
}

/**
 * Which unit a frame is of, as one number.
 * @param {UnitKey} unit
 */
function keyOf({ cascade, level, class: kind, group, codec }) {
  return (((cascade * 256 + level) * 4 + kind) * 16 + group) * 8 + codec;
}

/**
 * Fills in taps.
 * @param {DataView} view
 * @param {number} at
 * @param {Int16Array} taps
 * @returns {boolean} whether residuals have two bytes
 */
function readTaps(view, at, taps) {
  if (view.byteLength - at < TAPS_BYTES) throw new PayloadError('payload: too short');
  for (let i = 0; i < TAPS; i++) taps[i] = view.getInt16(at + 2 * i, true);
  const wide = view.getUint32(at + 2 * TAPS, true);
  if (wide > 1) throw new PayloadError('payload: bytes after the taps');
  return wide === 1;
}

/**
 * A 16-bit float.
 * @param {number} bits
 */
function fromHalf(bits) {
  const sign = bits & 0x8000 ? -1 : 1, exponent = bits >> 10 & 31, fraction = bits & 1023;
  if (exponent === 31) return fraction === 0 ? sign * Infinity : NaN;
  return sign * (exponent === 0 ? fraction * 2 ** -24 : (1024 + fraction) * 2 ** (exponent - 25));
}
