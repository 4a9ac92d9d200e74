// Frames joined by the kernels: the same of counts and of values, for as many patches as there are, in memory that goes
// back.

import assert from 'node:assert/strict';
import test from 'node:test';
import { Decoder, decodeFrame } from '../src/decode.js';
import { Playback } from '../src/playback.js';
import { ransPlane } from './codec.js';
import { makeFrame } from './frames.js';

const TICKS = [4800, 5280, 5760, 6240], AT = 5500;
const F32 = 4, RANS = 1, STEP = Math.fround(0.002);

const cascade = (index, n) => ({ index, patch_m: 64 / index, n, levels: 1, wavelength_min_m: 1, wavelength_max_m: 9, from_tick: 0, until_tick: null });
const count = (tick, i) => Math.imul(i + tick, 0x9e3779b1) >> 20;

/** Displacement of cascades, each of four ticks. */
function held(cascades, frame) {
  const units = cascades.map(({ index }) => ({ cascade: index, level: 0, class: '1mm', group: 'displacement' }));
  const playback = new Playback({ cascades }, { rateHz: 15, units });
  for (const { index, n } of cascades) {
    for (const tick of TICKS) assert.ok(playback.accept(decodeFrame(frame({ cascade: index, n, tick }))));
  }
  return playback;
}

const counted = (over) => makeFrame({ value: (i) => count(over.tick, i), ...over });
const valued = (over) => {
  const values = Float32Array.from({ length: 3 * over.n * over.n }, (_, i) => STEP * count(over.tick, i));
  return makeFrame({ codec: F32, payload: new Uint8Array(values.buffer), ...over });
};

test('frames of values, of counts, and of both are the same water', () => {
  const sampled = (frame) => held([cascade(1, 16)], frame).sample(AT)[0].values;
  const counts = sampled(counted);
  for (const frame of [valued, (over) => (over.tick === TICKS[2] ? valued(over) : counted(over))]) {
    sampled(frame).forEach((value, i) => assert.ok(Math.abs(value - counts[i]) < 1e-5, `sample ${i}`));
  }
});

test('what is sampled of a patch stands while memory grows for the next', () => {
  const cascades = [1, 2, 3, 4].map((index) => cascade(index, 256));
  const sampled = held(cascades, counted).sample(AT);
  assert.equal(sampled.length, 4);
  for (const { values } of sampled) {
    assert.equal(values.length, 3 * 65536);
    assert.deepEqual(values, sampled[0].values);
  }
});

test('who lets go of a sea gives its memory back', () => {
  const size = () => {
    const playback = held([cascade(1, 64)], counted);
    playback.sample(AT);
    const { memory } = playback.units[0][0].joined.kernels.exports;
    playback.dispose();
    return memory.buffer.byteLength;
  };
  const first = size();
  for (let round = 0; round < 200; round++) assert.equal(size(), first);
});

test('a decoder that forgets a unit gives its memory back', () => {
  const decoder = new Decoder(1 << 24), n = 64;
  const plane = ransPlane(new Int16Array(n * n), { depth: 0, planes: [] }, new Array(8).fill(0), n);
  const size = () => {
    decoder.decode(makeFrame({ group: 3, codec: RANS, n, tick: 0, payload: plane }));
    const { byteLength } = decoder.kernels.exports.memory.buffer;
    decoder.retain(() => false);
    return byteLength;
  };
  const first = size();
  for (let round = 0; round < 200; round++) assert.equal(size(), first);
});
