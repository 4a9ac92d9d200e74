// What frames say of a place and of all places: sums, wrapping, tiles, and the particle that was displaced to a place.

import assert from 'node:assert/strict';
import test from 'node:test';
import { decodeFrame } from '../src/decode.js';
import { Playback } from '../src/playback.js';
import { makeFrame } from './frames.js';

const TICK = 4800;

/** One cascade of 64 m whose displacement is given as counts of 2 mm, by channel, x and z. */
function held(plane, n = 64, over = {}) {
  const cascade = { index: 1, patch_m: 64, n, levels: 1, wavelength_min_m: 1, wavelength_max_m: 9, from_tick: 0, until_tick: null };
  const unit = { cascade: 1, level: 0, class: '1mm', group: 'displacement' };
  const playback = new Playback({ cascades: [cascade] }, { rateHz: 15, units: [unit] });
  const tile = Math.min(n, 256);
  for (let tileZ = 0; tileZ < n / tile; tileZ++) {
    for (let tileX = 0; tileX < n / tile; tileX++) {
      const value = (i) => plane(Math.floor(i / tile / tile), i % tile + tileX * tile, Math.floor(i / tile) % tile + tileZ * tile);
      playback.accept(decodeFrame(makeFrame({ n: tile, levelN: n, tileX, tileZ, tick: TICK, value, ...over })));
    }
  }
  playback.seek(TICK);
  return playback;
}

const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-6, `${a} is not ${b}`);

test('height between samples, and across the seam', () => {
  const playback = held((c, x) => (c === 1 ? x * 10 : 0));
  near(playback.heightAt(10.5, 3), 0.21);
  near(playback.heightAt(10.5 + 640, 3 - 64), 0.21);
  near(playback.heightAt(-0.5, 0), 0.63);
});

test('a particle that was moved is found', () => {
  const playback = held((c, x) => (c === 0 ? 1000 : c === 1 ? x * 10 : 0)); // all 2 m to the east
  near(playback.heightAt(12, 5), 0.2);
});

test('a patch in tiles is one patch: across their edges, and as a whole', () => {
  const playback = held((c, x, z) => (c === 1 ? x + 3 * z : 0), 512);
  near(playback.heightAt(255.5 / 8, 300 / 8), 0.002 * (255.5 + 900));
  near(playback.heightAt(100 / 8, 255.25 / 8), 0.002 * (100 + 3 * 255.25));
  near(playback.heightAt(511.5 / 8, 0), 0.002 * 255.5);
  const [{ n, values, group }] = playback.sample(TICK);
  assert.deepEqual([n, group, values.length], [512, 'displacement', 3 * 512 * 512]);
  for (const [x, z] of [[0, 0], [255, 256], [256, 255], [511, 511]]) {
    assert.equal(values[512 * 512 + z * 512 + x], Math.fround(Math.fround(0.002) * (x + 3 * z)));
  }
});

test('between frames all samples lie on the curve through four of them', () => {
  const cubic = (t) => Math.round(1000 * ((t / 2400) ** 3 - t / 2400));
  const playback = held(() => 0);
  for (let tick = TICK + 480; tick <= TICK + 1440; tick += 480) {
    playback.accept(decodeFrame(makeFrame({ n: 64, tick, value: (i) => (Math.floor(i / 4096) === 1 ? cubic(tick - TICK) : 0) })));
  }
  const at = (tick) => playback.sample(tick, ['displacement'])[0].values[4096 + 77];
  assert.ok(Math.abs(at(TICK + 700) - 0.002 * cubic(700)) < 0.003);
  assert.equal(playback.heightAt(5, 5).toFixed(5), at(TICK + 700).toFixed(5));
  assert.deepEqual(playback.sample(TICK + 700, ['foam']), [], 'what is not held is not sampled');
});

test('all samples are what each of them is by itself, with either sign', () => {
  const count = (tick) => (i) => (Math.imul(i + tick, 0x9e3779b1) >> 16); // anything that fits into 16 bits
  const playback = held(() => 0);
  for (let tick = TICK + 480; tick <= TICK + 1920; tick += 480) {
    playback.accept(decodeFrame(makeFrame({ n: 64, tick, value: count(tick) })));
  }
  const [{ values }] = playback.sample(TICK + 1100, ['displacement']);
  for (let i = 0; i < 64 * 64; i++) {
    const one = playback.displacementAt(i % 64, Math.floor(i / 64));
    for (let c = 0; c < 3; c++) assert.ok(Math.abs(values[c * 4096 + i] - one[c]) < 1e-5, `channel ${c}, sample ${i}`);
  }
});
