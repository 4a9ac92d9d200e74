// What is held of the sea across a further hello: frames of cascades that go on, and nothing outside their ticks.
// The GPU is one that does nothing.

import assert from 'node:assert/strict';
import test from 'node:test';
import { decodeFrame } from '../src/decode.js';
import { Fields } from '../src/sea/fields.js';
import { waterHeight } from '../src/sea/probe.js';
import { makeFrame } from './frames.js';

const CASCADE = { index: 0, patch_m: 64, n: 8, levels: 1, wavelength_min_m: 1, wavelength_max_m: 9, from_tick: 0, until_tick: null };
const OLD = { ...CASCADE, until_tick: 9600 }, NEW = { ...CASCADE, index: 8, from_tick: 4800 };

/** Any name is a function that gives nothing, or a constant. */
function idleGpu() {
  const drawn = [], disposed = [];
  const gl = new Proxy({}, { get: (_, name) => {
    if (/^[A-Z0-9_]+$/.test(name)) return 1;
    if (name === 'drawArrays') return () => drawn.push(1);
    if (name === 'deleteTexture') return (t) => disposed.push(t);
    if (/^get.*Parameter$/.test(name)) return () => 1;
    if (name === 'getActiveUniform') return () => ({ name: 'u' });
    return () => ({});
  } });
  return { gl, float32: true, anisotropy: 1, anisotropyName: null, drawn, disposed };
}

const planOf = (...cascades) => ({ rateHz: 15,
  units: ['displacement', 'slopes', 'derivatives'].flatMap((group) => cascades.map((c) => ({ cascade: c.index, level: 0, class: '1mm', group }))) });

/** Frames of three groups at some ticks, all of one count of 2 mm. */
function feed(fields, cascade, ticks, count) {
  let used = 0;
  for (const tick of ticks) {
    for (const group of [0, 1, 2]) {
      // Heights alone: what moves sideways would move the place that is looked at.
      const value = (i) => (group === 0 && Math.floor(i / 64) === 1 ? count : 0);
      used += fields.accept(decodeFrame(makeFrame({ cascade, group, tick, value }))) ? 1 : 0;
    }
  }
  return used;
}

test('a further hello keeps the frames of what goes on, and the picture', () => {
  const gpu = idleGpu();
  const first = new Fields(gpu, { cascades: [CASCADE] }, planOf(CASCADE));
  assert.equal(feed(first, 0, [3840, 4320, 4800, 5280, 5760], 100), 15);
  first.seek(4500, [0, 0]);
  assert.equal(first.complete, true);
  const next = new Fields(gpu, { cascades: [OLD, NEW] }, planOf(OLD, NEW), first);
  first.dispose();
  assert.equal(next.complete, true, 'no black picture');
  assert.equal(next.seek(4600, [0, 0]), false, 'not starved');
  assert.deepEqual(next.active, [0]);
  assert.ok(Math.abs(waterHeight(next, 1, 1) - 0.2) < 1e-6, 'the frames are there');
  // The new cascade has begun, and nothing of it is there yet.
  next.seek(5000, [0, 0]);
  assert.deepEqual([next.active, next.complete], [[0, 1], true]);
  assert.ok(Math.abs(waterHeight(next, 1, 1) - 0.2) < 1e-6, 'what is not there counts as nothing');
});

test('a cascade counts at its own ticks alone, and is let go of at its end', () => {
  const gpu = idleGpu();
  const fields = new Fields(gpu, { cascades: [OLD, NEW] }, planOf(OLD, NEW));
  feed(fields, 8, [4800, 5280, 5760, 6240, 9600, 10080], 50);
  feed(fields, 0, [3840, 4320, 4800, 5280, 5760, 6240], 100);
  const height = (tick) => {
    fields.seek(tick, [0, 0]);
    return Math.round(waterHeight(fields, 1, 1) * 1000);
  };
  assert.equal(height(4700), 200, 'the new one is held, and has not begun');
  assert.deepEqual([fields.active, fields.finest], [[0], 0]);
  assert.equal(height(5300), 300);
  assert.deepEqual([fields.active, fields.finest], [[0, 1], 0], 'ripples are still of the old one');
  assert.equal(height(4700), 200, 'also for a clock that was set back');
  const before = gpu.disposed.length;
  assert.equal(height(9700), 100);
  assert.deepEqual([fields.active, fields.finest], [[1], 1]);
  assert.equal(gpu.disposed.length, before + 3, 'what ended costs nothing');
  assert.equal(fields.ahead(9700), 380, 'what ended is not behind');
});

test('the end of a cascade is no starvation', () => {
  const fields = new Fields(idleGpu(), { cascades: [OLD, NEW] }, planOf(OLD, NEW));
  feed(fields, 8, [8160, 8640, 9120, 9600], 50);
  feed(fields, 0, [7200, 7680], 100);
  assert.equal(fields.seek(8000, [0, 0]), true);
  feed(fields, 0, [8160, 8640, 9120], 0);
  assert.equal(fields.seek(9300, [0, 0]), false);
});

test('another cascade of the same number is another', () => {
  const first = new Fields(idleGpu(), { cascades: [CASCADE] }, planOf(CASCADE));
  feed(first, 0, [4800], 100);
  const later = { ...CASCADE, from_tick: 4800 };
  const next = new Fields(idleGpu(), { cascades: [later] }, planOf(later), first);
  next.seek(4800, [0, 0]);
  assert.equal(waterHeight(next, 1, 1), 0);
});

test('a unit comes coarser, and fine again: each is shown from its first frame on', () => {
  const gpu = idleGpu(), wide = { ...CASCADE, n: 16, levels: 2 };
  const fields = new Fields(gpu, { cascades: [wide] }, planOf(wide));
  const send = (level, ticks, count) => {
    for (const tick of ticks) {
      for (const group of [0, 1, 2]) {
        const n = 16 >> level, value = (i) => (group === 0 && Math.floor(i / n / n) === 1 ? count : 0);
        assert.ok(fields.accept(decodeFrame(makeFrame({ cascade: 0, group, tick, n, level, value }))));
      }
    }
  };
  const look = (tick) => {
    fields.seek(tick, [0, 0]);
    return [Math.round(waterHeight(fields, 1, 1) * 1000), fields.levels()];
  };
  send(0, [480, 960, 1440, 1920], 100);
  send(1, [2400, 2880, 3360, 3840], 50);
  assert.deepEqual(look(1000), [200, [0]]);
  assert.equal(fields.ahead(1000), 2840, 'what is to come is held');
  assert.deepEqual(look(2100), [200, [0]], 'the last fine one stays until then');
  const before = gpu.disposed.length;
  assert.deepEqual(look(2410), [100, [1]]);
  assert.equal(gpu.disposed.length, before + 3);
  assert.equal(fields.size, 16);
  send(0, [4320, 4800], 70);
  assert.deepEqual(look(4330), [140, [0]]);
  const wrong = (over) => fields.accept(decodeFrame(makeFrame({ cascade: 0, tick: 5280, ...over })));
  assert.deepEqual([wrong({ level: 1, n: 16 }), wrong({ level: 2, n: 8 }), wrong({ level: 40, n: 8 })], [false, false, false]);
});

test('what is coarser stays over a further hello, until the fine frames come', () => {
  const gpu = idleGpu(), wide = { ...CASCADE, n: 16, levels: 2 };
  const first = new Fields(gpu, { cascades: [wide] }, planOf(wide));
  for (const tick of [480, 960]) {
    for (const group of [0, 1, 2]) first.accept(decodeFrame(makeFrame({ cascade: 0, group, tick, n: 8, level: 1, value: () => 0 })));
  }
  first.seek(500, [0, 0]);
  const next = new Fields(gpu, { cascades: [wide] }, planOf(wide), first);
  assert.deepEqual([next.levels(), next.size, next.seek(600, [0, 0])], [[1], 16, false]);
});
