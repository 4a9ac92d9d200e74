// The ring of frames: exact on cubics, fewer points at edges, holding when starved.

import assert from 'node:assert/strict';
import test from 'node:test';
import { Pick, Ring, RING_SLOTS } from '../src/ring.js';

const INTERVAL = 480;
const cubic = (t) => 3 + t / 500 - (t / 700) ** 2 + (t / 900) ** 3;

/** A ring whose frames hold one number each. */
class Numbers {
  constructor(tiles = 1) {
    this.ring = new Ring(INTERVAL, tiles);
    this.values = new Float64Array(RING_SLOTS);
    this.pick = new Pick();
  }

  put(k, value = cubic(k * INTERVAL)) {
    const slot = this.ring.place(k * INTERVAL);
    if (slot >= 0) this.values[slot] = value;
    return slot;
  }

  at(tick) {
    const { weights, slots } = this.ring.pick(tick, this.pick);
    return weights.reduce((sum, w, i) => sum + w * this.values[slots[i]], 0);
  }
}

test('four frames: exact on a cubic', () => {
  const n = new Numbers();
  for (let k = 10; k < 16; k++) n.put(k);
  for (let t = 11 * INTERVAL; t <= 14 * INTERVAL; t += 37) {
    assert.ok(Math.abs(n.at(t) - cubic(t)) < 1e-9);
    assert.equal(n.pick.starved, false);
  }
  assert.equal(n.pick.points, 4);
  n.at(12 * INTERVAL);
  assert.equal(n.pick.points, 1, 'on a frame: that frame alone');
});

test('order of arrival does not matter', () => {
  const n = new Numbers();
  for (const k of [14, 11, 13, 10, 12]) n.put(k);
  const t = 12.3 * INTERVAL;
  assert.ok(Math.abs(n.at(t) - cubic(t)) < 1e-9);
});

test('at the edges fewer points, and weights still sum to 1', () => {
  const n = new Numbers();
  for (let k = 10; k < 14; k++) n.put(k);
  n.at(10.5 * INTERVAL);
  assert.equal(n.pick.points, 3);
  n.at(12.5 * INTERVAL);
  assert.equal(n.pick.points, 3);
  for (let t = 10 * INTERVAL; t < 13 * INTERVAL; t += 50) {
    n.at(t);
    assert.ok(Math.abs(n.pick.weights.reduce((a, b) => a + b) - 1) < 1e-12);
  }
  const two = new Numbers();
  two.put(10, 1);
  two.put(11, 3);
  assert.equal(two.at(10.25 * INTERVAL), 1.5);
});

test('past the last frame it holds, and says so', () => {
  const n = new Numbers();
  for (let k = 10; k < 14; k++) n.put(k);
  assert.equal(n.at(13 * INTERVAL), cubic(13 * INTERVAL));
  assert.equal(n.pick.starved, false, 'the last frame itself is no starvation');
  assert.equal(n.at(15.7 * INTERVAL), cubic(13 * INTERVAL));
  assert.equal(n.pick.starved, true);
  assert.equal(n.at(9.9 * INTERVAL), cubic(10 * INTERVAL));
  assert.equal(n.pick.starved, true);
});

test('nothing held: nothing to show', () => {
  const n = new Numbers();
  n.at(100);
  assert.equal(n.pick.points, 0);
  assert.equal(n.pick.starved, true);
});

test('a skipped tick is bridged by the frames about it', () => {
  const n = new Numbers();
  for (const k of [10, 11, 13, 14]) n.put(k);
  const t = 12.2 * INTERVAL;
  assert.ok(Math.abs(n.at(t) - cubic(t)) < 1e-9);
  assert.equal(n.pick.starved, false);
});

test('a long gap is a straight line, not a swing', () => {
  const n = new Numbers();
  n.put(10, 0);
  n.put(11, 0);
  n.put(16, 5);
  n.put(17, 5);
  assert.equal(n.at(13.5 * INTERVAL), 2.5);
});

test('dropped: off the grid, duplicates, and older than what its slot holds', () => {
  const n = new Numbers();
  assert.equal(n.ring.place(INTERVAL + 1), -1);
  assert.ok(n.put(30) >= 0);
  assert.equal(n.put(30), -1);
  assert.equal(n.put(30 - RING_SLOTS), -1);
  assert.ok(n.put(30 + RING_SLOTS) >= 0);
});

test('a patch in tiles counts once all have come', () => {
  const n = new Numbers(4);
  for (let i = 0; i < 3; i++) n.put(10);
  n.at(10 * INTERVAL);
  assert.equal(n.pick.points, 0);
  n.put(10);
  n.at(10 * INTERVAL);
  assert.equal(n.pick.points, 1);
  assert.equal(n.ring.newest, 10 * INTERVAL);
});

test('whether a time is reached', () => {
  const n = new Numbers(2);
  n.put(10);
  assert.equal(n.ring.reaches(12 * INTERVAL), false, 'half a frame is none');
  n.put(10);
  assert.deepEqual([9, 10, 12].map((k) => n.ring.reaches(k * INTERVAL)), [false, true, true]);
});

/** Arrivals of a stream of 60 Hz: by layer, so far ahead of its tick. */
const LEADS = [1680, 1200, 1080];

test('frames of layers come out of order and later: whatever is there, four points, never starved', () => {
  for (const layers of [1, 2, 3]) {
    const interval = 120, ring = new Ring(interval), values = new Float64Array(RING_SLOTS), pick = new Pick();
    const layerOf = (t) => (t % 480 === 0 ? 0 : t % 240 === 0 ? 1 : 2);
    for (let now = 0; now < 20_000; now += 40) {
      for (const [layer, lead] of LEADS.slice(0, layers).entries()) {
        const tick = now + lead;
        if (tick % interval !== 0 || layerOf(tick) !== layer) continue;
        const slot = ring.place(tick);
        assert.ok(slot >= 0, `${layers} layers: frame ${tick} dropped at ${now}`);
        values[slot] = cubic(tick);
      }
      if (now < 3000) continue;
      const { weights, slots, starved, points } = ring.pick(now + 7, pick);
      const at = weights.reduce((sum, w, i) => sum + w * values[slots[i]], 0);
      assert.deepEqual([starved, points], [false, 4]);
      assert.ok(Math.abs(at - cubic(now + 7)) < 1e-6, `${layers} layers at ${now}`);
    }
  }
});

test('fewer frames from now on: a curve goes from the dense ones to the sparse ones', () => {
  const ring = new Ring(120), values = new Float64Array(RING_SLOTS), pick = new Pick();
  for (const tick of [4800, 4920, 5040, 5160, 5280, 5760, 6240]) values[ring.place(tick)] = cubic(tick);
  for (let t = 5040; t < 5760; t += 17) {
    const { weights, slots, points } = ring.pick(t, pick);
    if (points === 4) assert.ok(Math.abs(weights.reduce((sum, w, i) => sum + w * values[slots[i]], 0) - cubic(t)) < 1e-6);
    else assert.equal(t, 5040);
  }
});
