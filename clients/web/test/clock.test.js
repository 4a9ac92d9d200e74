// The clock under jitter, drift, asymmetry and steps, on simulated time.

import assert from 'node:assert/strict';
import test from 'node:test';
import { Clock } from '../src/clock.js';

/** A repeatable random number, 0 to 1. */
function randomFrom(seed) {
  let s = seed >>> 0;
  return () => {
    s = (Math.imul(s, 1664525) + 1013904223) >>> 0;
    return ((s ^ (s >>> 13)) >>> 0) / 4294967296;
  };
}

/** Runs exchanges as the connection does: 30 fast ones, then one a second. Calls `each(now)` after every one. */
function run(clock, { seconds, delay, server, seed = 1, from = 0, each = () => {} }) {
  const random = randomFrom(seed);
  let now = from;
  for (let i = 0; now < from + seconds * 1000; i++) {
    const there = delay(random), back = delay(random);
    const t1 = server(now + there), t2 = t1 + 0.05;
    const t3 = now + there + 0.05 + back;
    clock.exchange(now, t1, t2, t3);
    each(t3);
    now += i < 30 ? 100 : 1000;
  }
  return now;
}

test('nothing to show before the first exchange', () => {
  const clock = new Clock();
  assert.equal(clock.synced, false);
  assert.ok(Number.isNaN(clock.serverMs(5)));
  assert.equal(clock.quality(5).boundMs, Infinity);
});

test('on a quiet LAN the error is below 1 ms, and below the bound', () => {
  const server = (t) => t + 1e9;
  const clock = new Clock();
  const end = run(clock, { seconds: 30, delay: (r) => 0.2 + 0.4 * r(), server });
  const error = Math.abs(clock.serverMs(end) - server(end));
  assert.ok(error < 0.3, `error ${error}`);
  assert.ok(error <= clock.quality(end).boundMs);
});

test('after 30 s at 20 +- 10 ms each way the error is within 3 ms at p99', () => {
  const errors = [];
  for (let seed = 1; seed <= 300; seed++) {
    const server = (t) => t * (1 + 3e-5) + 5e8;
    const clock = new Clock();
    let end = 0;
    run(clock, { seconds: 30, delay: (r) => 10 + 20 * r(), server, seed, each: (now) => { end = now; clock.serverMs(now); } });
    const error = Math.abs(clock.serverMs(end) - server(end));
    errors.push(error);
    assert.ok(error <= clock.quality(end).boundMs, `seed ${seed}: ${error} above the bound`);
  }
  errors.sort((a, b) => a - b);
  assert.ok(errors[296] <= 3, `p99 ${errors[296]}`);
});

test('drift is found: the error stays small between exchanges that stop', () => {
  const server = (t) => t * (1 + 8e-5) + 7e7;
  const clock = new Clock();
  const end = run(clock, { seconds: 110, delay: (r) => 1 + r(), server });
  for (let now = end - 1000; now < end; now += 16) clock.serverMs(now);
  const later = end + 20_000;
  for (let now = end; now < later; now += 16) clock.serverMs(now);
  const error = Math.abs(clock.serverMs(later) - server(later));
  assert.ok(error < 1, `error ${error}; without drift it would be 1.6`);
});

test('a small change is slewed by at most 1 %, never backwards', () => {
  let shift = 0;
  const server = (t) => t + 1e6 + shift;
  const clock = new Clock();
  const quiet = () => 0.5;
  let end = run(clock, { seconds: 10, delay: quiet, server });
  let last = clock.serverMs(end);
  shift = -60;
  clock.samples.length = 0; // as if the old ones had aged out
  end = run(clock, { seconds: 3, delay: quiet, server, from: end });
  for (let now = end; now < end + 10_000; now += 16) {
    const shown = clock.serverMs(now);
    const rate = (shown - last) / 16;
    if (now > end) assert.ok(rate > 0.989 && rate < 1.011, `rate ${rate}`);
    assert.ok(shown > last);
    last = shown;
  }
  assert.ok(Math.abs(clock.serverMs(end + 10_000) - server(end + 10_000)) < 0.1);
  assert.equal(clock.steps, 0);
});

test('a change above 200 ms is a step', () => {
  let shift = 0;
  const server = (t) => t + 1e6 + shift;
  const clock = new Clock();
  let end = run(clock, { seconds: 10, delay: () => 1, server });
  clock.serverMs(end);
  shift = 5000;
  end = run(clock, { seconds: 1, delay: () => 1, server, from: end });
  assert.ok(Math.abs(clock.serverMs(end) - server(end)) < 1);
  assert.equal(clock.steps, 1);
});

test('absurd exchanges are left out', () => {
  const clock = new Clock();
  clock.exchange(10, 5, 6, 9); // came before it was sent
  clock.exchange(10, NaN, 6, 20);
  assert.equal(clock.synced, false);
});

test('a stall does not move the clock', () => {
  const server = (t) => t + 1e6;
  const clock = new Clock();
  let i = 0;
  const end = run(clock, { seconds: 60, server, delay: (r) => (i++ % 5 === 0 ? 300 * r() : 0) + 5 + r() });
  assert.ok(Math.abs(clock.serverMs(end) - server(end)) < 1);
});
