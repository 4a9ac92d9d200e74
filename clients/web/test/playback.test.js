// What is held of the sea across a further hello: frames of cascades that go on, and nothing outside their ticks.

import assert from 'node:assert/strict';
import test from 'node:test';
import { decodeFrame } from '../src/decode.js';
import { Playback } from '../src/playback.js';
import { makeFrame } from './frames.js';

const CASCADE = { index: 0, patch_m: 64, n: 8, levels: 1, wavelength_min_m: 1, wavelength_max_m: 9, from_tick: 0, until_tick: null };
const OLD = { ...CASCADE, until_tick: 9600 }, NEW = { ...CASCADE, index: 8, from_tick: 4800 };

/** A playback whose units count how many of them were let go of. */
function held(cascades, before = null, plan = planOf(...cascades)) {
  const playback = new Playback({ cascades }, plan, before);
  playback.disposed = 0;
  const watch = () => playback.all().forEach((unit) => { unit.attached ??= { dispose: () => { playback.disposed++; } }; });
  const { accept } = playback;
  playback.accept = (frame) => { const used = accept.call(playback, frame); watch(); return used; };
  watch();
  return playback;
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

const look = (playback, tick) => {
  playback.seek(tick);
  return Math.round(playback.heightAt(1, 1) * 1000);
};

test('a further hello keeps the frames of what goes on, and the picture', () => {
  const first = held([CASCADE]);
  assert.equal(feed(first, 0, [3840, 4320, 4800, 5280, 5760], 100), 15);
  first.seek(4500);
  assert.equal(first.complete, true);
  const next = held([OLD, NEW], first);
  assert.deepEqual([next.complete, first.all()], [true, []], 'no black picture, and nothing is held twice');
  assert.equal(next.seek(4600), false, 'not starved');
  assert.deepEqual(next.active, [0]);
  assert.equal(look(next, 4600), 200, 'the frames are there');
  // The new cascade has begun, and nothing of it is there yet.
  assert.equal(look(next, 5000), 200, 'what is not there counts as nothing');
  assert.deepEqual([next.active, next.complete], [[0, 1], true]);
});

test('a cascade counts at its own ticks alone, and is let go of at its end', () => {
  const playback = held([OLD, NEW]);
  feed(playback, 8, [4800, 5280, 5760, 6240, 9600, 10080], 50);
  feed(playback, 0, [3840, 4320, 4800, 5280, 5760, 6240], 100);
  assert.equal(look(playback, 4700), 200, 'the new one is held, and has not begun');
  assert.deepEqual([playback.active, playback.finest], [[0], 0]);
  assert.equal(look(playback, 5300), 300);
  assert.deepEqual([playback.active, playback.finest], [[0, 1], 0], 'ripples are still of the old one');
  assert.equal(look(playback, 4700), 200, 'also for a clock that was set back');
  assert.equal(look(playback, 9700), 100);
  assert.deepEqual([playback.active, playback.finest], [[1], 1]);
  assert.equal(playback.ahead(9700), 380, 'what ended is not behind');
  assert.equal(look(playback, 5300), 300, 'who looked ahead finds the present as it was');
  playback.seek(9600 + 7200);
  assert.equal(playback.disposed, 3, 'what ended costs nothing');
});

test('the end of a cascade is no starvation', () => {
  const playback = held([OLD, NEW]);
  feed(playback, 8, [8160, 8640, 9120, 9600], 50);
  feed(playback, 0, [7200, 7680], 100);
  assert.equal(playback.seek(8000), true);
  feed(playback, 0, [8160, 8640, 9120], 0);
  assert.equal(playback.seek(9300), false);
});

test('another cascade of the same number is another', () => {
  const first = held([CASCADE]);
  feed(first, 0, [4800], 100);
  const next = held([{ ...CASCADE, from_tick: 4800 }], first);
  assert.ok(Number.isNaN(look(next, 4800)));
});

const WIDE = { ...CASCADE, n: 16, levels: 2 };

/** Frames of the three groups of a cascade of 16 x 16, at a level. */
function send(playback, level, ticks, count) {
  for (const tick of ticks) {
    for (const group of [0, 1, 2]) {
      const n = 16 >> level, value = (i) => (group === 0 && Math.floor(i / n / n) === 1 ? count : 0);
      assert.ok(playback.accept(decodeFrame(makeFrame({ cascade: 0, group, tick, n, level, value }))));
    }
  }
}

test('a unit comes coarser, and fine again: each is shown from its first frame on', () => {
  const playback = held([WIDE]);
  send(playback, 0, [480, 960, 1440, 1920], 100);
  send(playback, 1, [2400, 2880, 3360, 3840], 50);
  assert.deepEqual([look(playback, 1000), playback.levels()], [200, [0]]);
  assert.equal(playback.ahead(1000), 2840, 'what is to come is held');
  assert.deepEqual([look(playback, 2100), playback.levels()], [200, [0]], 'the last fine one stays until then');
  assert.equal(playback.disposed, 0);
  assert.deepEqual([look(playback, 2410), playback.levels()], [100, [1]]);
  assert.equal(playback.disposed, 3);
  send(playback, 0, [4320, 4800], 70);
  assert.deepEqual([look(playback, 4330), playback.levels()], [140, [0]]);
  const wrong = (over) => playback.accept(decodeFrame(makeFrame({ cascade: 0, tick: 5280, ...over })));
  assert.deepEqual([wrong({ level: 1, n: 16 }), wrong({ level: 2, n: 8 }), wrong({ level: 40, n: 8 })], [false, false, false]);
});

test('what is coarser stays over a further hello, until the fine frames come', () => {
  const first = held([WIDE]);
  send(first, 1, [480, 960], 0);
  first.seek(500);
  const next = held([WIDE], first);
  assert.deepEqual([next.levels(), next.seek(600)], [[1], false]);
});

test('another level or rate is asked for: what is held is shown until the new frames reach the moment', () => {
  const asking = (level, rateHz) => ({ ...planOf(WIDE), rateHz, units: planOf(WIDE).units.map((u) => ({ ...u, level })) });
  const first = held([WIDE], null, asking(0, 15));
  send(first, 0, [480, 960, 1440], 100);
  first.seek(1000);
  const coarse = held([WIDE], first, asking(1, 15));
  assert.deepEqual([look(coarse, 1100), coarse.complete, coarse.starved], [200, true, false]);
  send(coarse, 1, [1440, 1920, 2400], 50);
  assert.deepEqual([look(coarse, 1430), coarse.levels()], [200, [0]]);
  assert.deepEqual([look(coarse, 1450), coarse.levels()], [100, [1]]);
  const fast = held([WIDE], coarse, asking(1, 30));
  send(fast, 1, [2640, 2880, 3120], 50);
  assert.deepEqual([look(fast, 2000), look(fast, 2500), fast.starved], [100, 100, false], 'frames of both rates make one curve');
  assert.deepEqual([look(fast, 2700), fast.units[0][0].ring.interval], [100, 240]);
  const slow = held([WIDE], fast, asking(1, 15));
  send(slow, 1, [3360, 3840], 50);
  assert.deepEqual([look(slow, 3500), slow.starved, slow.units[0][0].ring.interval], [100, false, 240]);
});

test('what is coming stays over a further hello, too', () => {
  const first = held([WIDE]);
  send(first, 1, [480, 960], 50);
  first.seek(500);
  send(first, 0, [1440, 1920], 70);
  const next = held([WIDE], first);
  assert.deepEqual([look(next, 1000), next.levels()], [100, [1]]);
  assert.deepEqual([look(next, 1500), next.levels()], [140, [0]], 'without a frame more');
});

test('without displacement there is no height, rather than none', () => {
  const slopes = { rateHz: 15, units: [{ cascade: 0, level: 0, class: '1mm', group: 'slopes' }] };
  const playback = held([CASCADE], null, slopes);
  for (const tick of [480, 960]) playback.accept(decodeFrame(makeFrame({ cascade: 0, group: 1, tick, value: () => 0 })));
  playback.seek(500);
  assert.deepEqual([playback.complete, playback.heightAt(0, 0)], [true, NaN]);
});

test('a moment is chosen anew once more frames have come', () => {
  const playback = held([WIDE]);
  send(playback, 0, [480], 100);
  assert.equal(look(playback, 500), 200);
  send(playback, 0, [960], 300);
  assert.ok(Number.isNaN(playback.tick));
});
