// The viewer's own sums: the deck that floats, a view's clip space, and quality that gives way.

import assert from 'node:assert/strict';
import test from 'node:test';
import { Deck, FREEBOARD_M } from '../viewer/deck.js';
import { Lift } from '../viewer/lift.js';
import { Pace } from '../viewer/pace.js';
import { Quality, stepsOf } from '../viewer/quality.js';
import { View } from '../viewer/view.js';

const near = (a, b, within = 1e-9) => assert.ok(Math.abs(a - b) <= within, `${a} is not ${b}`);

test('a deck lies on the plane of the water, whatever way it heads', () => {
  const deck = new Deck(), plane = (x, z) => 1.5 + 0.02 * x - 0.03 * z;
  for (const heading of [0, 37, 90, 262]) {
    deck.moor(40, -7, heading);
    deck.float(plane);
    near(deck.y, plane(40, -7) + FREEBOARD_M);
    for (const [x, z] of [[40, -7], [41, -8], [39.2, -6.1]]) near(deck.heightAt(x, z), plane(x, z) + FREEBOARD_M);
    assert.equal(deck.heightAt(60, -7), null, 'beside it');
    const m = deck.matrix(), [along, across] = deck.local(41, -8);
    const world = [0, 1, 2].map((i) => m[i] * across + m[8 + i] * along + m[12 + i]);
    [41, deck.heightAt(41, -8), -8].forEach((v, i) => near(world[i], v, 1e-5));
  }
});

test('short waves below the hull move it less than long ones', () => {
  const swing = (length) => {
    const deck = new Deck();
    const heights = Array.from({ length: 32 }, (_, i) => {
      deck.float((x, z) => Math.sin(2 * Math.PI * (z / length + i / 32)));
      return deck.y;
    });
    return (Math.max(...heights) - Math.min(...heights)) / 2;
  };
  assert.ok(swing(100) > 0.9 && swing(6) < 0.35, `${swing(100)}, ${swing(6)}`);
});

test('clip space of an asymmetric view: its edges are at 1, and what lies outside is not seen', () => {
  const view = new View();
  view.look([3, 2, 1], { right: [1, 0, 0], up: [0, 1, 0], forward: [0, 0, -1], near: 0.1 }, [-1.2, 0.8, -1, 0.9]);
  const clip = (x, y, z) => {
    const at = [0, 1, 2, 3].map((i) => view.clip[i] * x + view.clip[4 + i] * y + view.clip[8 + i] * z + view.clip[12 + i]);
    return [at[0] / at[3], at[1] / at[3]];
  };
  for (const [x, y, wanted] of [[-1.2, -1, [-1, -1]], [0.8, 0.9, [1, 1]]]) clip(5 * x, 5 * y, -5).forEach((v, i) => near(v, wanted[i], 1e-6));
  const box = (x, y, z) => [x - 0.1, y - 0.1, z - 0.1, x + 0.1, y + 0.1, z + 0.1];
  assert.deepEqual([view.sees(box(0, 0, -5)), view.sees(box(-7, 0, -5)), view.sees(box(4.5, 0, -5)), view.sees(box(0, 0, 5))], [true, false, false, false]);
});

test('the water lifts an eye at once, and lets it down gently', () => {
  const lift = new Lift();
  near(lift.above(1, 2, 0.01), 2.7);
  const later = lift.above(1, -5, 1);
  assert.ok(later > 1.5 && later < 1.7, String(later));
});

/** Seconds of pictures at 90 Hz that cost so much; the steps that are taken. */
function steps(quality, seconds, costMs, intervalMs = 1000 / 90, whole = false) {
  const taken = [];
  for (let ms = 0; ms < seconds * 1000; ms += intervalMs) {
    const step = quality.picture(intervalMs, costMs, 1000 / 90, whole);
    if (step) taken.push(step);
  }
  return taken;
}

test('quality gives way in layers, then levels, then in the mesh, before anything is dropped', () => {
  const all = stepsOf({ rate: 60, level: 0 }, 4);
  assert.deepEqual(all.map((s) => [s.rate, s.level, s.coarse]), [[60, 0, false], [30, 0, false], [15, 0, false], [15, 1, false], [15, 2, false], [15, 2, true]]);
  assert.deepEqual(stepsOf({ rate: 15, level: 0 }, 1).map((s) => [s.rate, s.level, s.coarse]), [[15, 0, false], [15, 0, true]]);
  const quality = new Quality(all);
  assert.deepEqual(steps(quality, 5, 6), [], 'half of the time: neither');
  assert.equal(steps(quality, 3.1, 9.5).length, 3, 'above three quarters: one step a second');
  assert.equal(steps(quality, 2.1, 6, 22, true).length, 0, 'dropped by somebody else: the cost is known');
  assert.equal(steps(quality, 2.1, 6, 22).length, 2, 'dropped pictures alone');
  assert.equal(steps(quality, 60, 9.5).length, 0, 'and no further than the last');
});

test('what was given up comes back when there is time, later each time that it was too much', () => {
  const quality = new Quality(stepsOf({ rate: 30, level: 0 }, 1));
  const until = () => {
    for (let s = 1; s < 400; s++) if (steps(quality, 1.005, 2).length > 0) return s;
    return Infinity;
  };
  steps(quality, 1.1, 10);
  assert.equal(quality.at, 1);
  const first = until();
  steps(quality, 1.1, 10);
  const second = until();
  assert.ok(first >= 9 && first <= 11, String(first));
  assert.ok(second >= 18 && second <= 22, String(second));
});

test('pictures that the display could have had are counted', () => {
  const pace = new Pace();
  for (let i = 0; i < 120; i++) pace.picture(1000 / 72, 9, undefined);
  near(pace.targetMs, 1000 / 72, 1e-6);
  assert.equal(pace.dropped, 0);
  pace.picture(3 * 1000 / 72, 9, undefined);
  assert.equal(pace.dropped, 2);
  const slow = new Pace(), kept = new Pace();
  for (let i = 0; i < 60; i++) {
    slow.picture(1000 / 30, 3, undefined);
    kept.picture(1000 / 30, 20, undefined);
  }
  near(slow.targetMs, 1000 / 30, 1e-6); // a display of 30 Hz
  near(kept.targetMs, 1000 / 45, 1e-6); // a display that is kept waiting
});
