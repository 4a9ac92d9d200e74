// The water's height from frames: sums, wrapping, and the particle that was displaced to a place.

import assert from 'node:assert/strict';
import test from 'node:test';
import { decodeFrame } from '../src/decode.js';
import { Pick } from '../src/playback.js';
import { waterHeight } from '../src/sea/probe.js';
import { makeFrame } from './frames.js';

/** Fields of one cascade of 64 m whose planes are given as counts of 2 mm. */
function fieldsOf(plane) {
  const frame = decodeFrame(makeFrame({ n: 64, value: (i) => plane(Math.floor(i / 4096), i % 64, Math.floor(i / 64) % 64) }));
  const pick = new Pick();
  pick.weights[0] = 1;
  pick.points = 1;
  return { patches: [64], units: [[{ pick, frames: [[frame]] }]] };
}

test('height between samples, and across the seam', () => {
  const fields = fieldsOf((c, x) => (c === 1 ? x * 10 : 0));
  assert.ok(Math.abs(waterHeight(fields, 10.5, 3) - 0.21) < 1e-6);
  assert.ok(Math.abs(waterHeight(fields, 10.5 + 640, 3 - 64) - 0.21) < 1e-6);
  assert.ok(Math.abs(waterHeight(fields, -0.5, 0) - 0.63) < 1e-6);
});

test('a particle that was moved is found', () => {
  const fields = fieldsOf((c, x) => (c === 0 ? 1000 : c === 1 ? x * 10 : 0)); // all 2 m to the east
  assert.ok(Math.abs(waterHeight(fields, 12, 5) - 0.2) < 1e-6);
});
