// What takes most of a client's time, in WebAssembly: reading coded planes, and joining frames in time. Compiled from
// `kernels/`, by the server's own decoder; `.ci/kernels` says how.
//
// Invariant: views of memory are good until something more is taken.

import { WASM } from './kernels.wasm.js';

/**
 * @typedef {object} Exports see `kernels/src/lib.rs`; what is taken is called by a number
 * @property {WebAssembly.Memory} memory
 * @property {(bytes: number) => number} message
 * @property {(length: number) => number} take_counts
 * @property {(name: number) => number} counts_at
 * @property {(name: number) => void} give_counts
 * @property {(length: number) => number} take_values
 * @property {(name: number) => number} values_at
 * @property {(name: number) => void} give_values
 * @property {(at: number, depth: number, channel: number, n: number, out: number, a: number, b: number, c: number) => number} read_plane
 * @property {() => number} fault_at
 * @property {() => number} fault_bytes
 * @property {(out: number, channel: number, samples: number, a: number, b: number, c: number, d: number,
 *   wa: number, wb: number, wc: number, wd: number) => void} join
 */

/** @type {WebAssembly.Module | undefined} */
let compiled;

export class Kernels {
  constructor() {
    compiled ??= new WebAssembly.Module(Uint8Array.from(atob(WASM), (character) => character.charCodeAt(0)));
    this.exports = /** @type {Exports} */ (/** @type {unknown} */ (new WebAssembly.Instance(compiled).exports));
  }

  /**
   * Takes over a message, for planes to be read from it.
   * @param {Uint8Array} bytes
   */
  hold(bytes) {
    const at = this.exports.message(bytes.length);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
  }

  /**
   * @param {number} name
   * @param {number} from
   * @param {number} length
   */
  counts(name, from, length) {
    return new Int16Array(this.exports.memory.buffer, this.exports.counts_at(name) + 2 * from, length);
  }

  /**
   * @param {number} name
   * @param {number} length
   */
  values(name, length) {
    return new Float32Array(this.exports.memory.buffer, this.exports.values_at(name), length);
  }

  /** Why the last plane was not read. */
  fault() {
    const { memory, fault_at: at, fault_bytes: bytes } = this.exports;
    return new TextDecoder().decode(new Uint8Array(memory.buffer, at(), bytes()));
  }
}
