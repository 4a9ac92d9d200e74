// The shared clock: the vectors that the Rust client is held to as well, and its laws on simulated time.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import test from 'node:test';
import { Clock } from '../src/clock.js';
import { randomFrom } from './frames.js';

test('vectors of the repository', (t) => {
  const file = new URL('../../../proto/vectors/clock.json', import.meta.url);
  if (!existsSync(file)) {
    console.error('SKIPPED: no proto/vectors/clock.json');
    if (process.env.SWELLCAST_REQUIRE_VECTORS === '1') assert.fail('no proto/vectors/clock.json');
    t.skip('no vectors');
    return;
  }
  for (const { name, exchanges, queries } of JSON.parse(readFileSync(file, 'utf8'))) {
    const clock = new Clock();
    let taken = 0;
    for (const { after, at, server_us: server, error_bound_us: bound } of queries) {
      for (; taken < after; taken++) {
        const [t0, t1, t2, t3] = exchanges[taken];
        clock.observe({ t0, t1, t2, t3 });
      }
      const where = `${name}, at ${at}`;
      if (server === null) {
        assert.ok(!clock.synced, where);
      } else {
        assert.ok(Math.abs(clock.serverUs(at) - server) <= 1, `${where}: ${clock.serverUs(at)}, must be ${server}`);
        assert.ok(Math.abs(clock.errorBoundUs(at) - bound) <= 1, `${where}: bound ${clock.errorBoundUs(at)}, must be ${bound}`);
      }
    }
    assert.equal(taken, exchanges.length, `${name}: every exchange is taken before some query`);
  }
});

/** Runs exchanges as the connection does: 20 fast ones, then one a second. Calls `each(now)` after every one. */
function run(clock, { seconds, delay, server, seed = 1, from = 0, each = () => {} }) {
  const random = randomFrom(seed);
  let now = from;
  for (let i = 0; now < from + seconds * 1e6; i++) {
    const there = delay(random), back = delay(random), t1 = server(now + there);
    const t3 = now + there + 50 + back;
    clock.observe({ t0: now, t1, t2: t1 + 50, t3 });
    each(t3);
    now += i < 20 ? 1e5 : 1e6;
  }
  return now;
}

test('nothing to show before the first exchange', () => {
  const clock = new Clock();
  assert.deepEqual([clock.synced, clock.serverUs(5), clock.errorBoundUs(5)], [false, NaN, Infinity]);
});

test('on a quiet LAN the error is below 1 ms, and below the bound', () => {
  const server = (t) => t + 1e12, clock = new Clock();
  const end = run(clock, { seconds: 30, delay: (r) => 200 + 400 * r(), server });
  const error = Math.abs(clock.serverUs(end) - server(end));
  assert.ok(error < 300, `error ${error}`);
  assert.ok(error <= clock.errorBoundUs(end));
});

test('after 30 s at 20 +- 10 ms each way the error is within 3 ms at p99', () => {
  const errors = [];
  for (let seed = 1; seed <= 300; seed++) {
    const server = (t) => t * (1 + 3e-5) + 5e11, clock = new Clock();
    let end = 0;
    run(clock, { seconds: 30, delay: (r) => 1e4 + 2e4 * r(), server, seed, each: (now) => { end = now; } });
    const error = Math.abs(clock.serverUs(end) - server(end));
    errors.push(error);
    assert.ok(error <= clock.errorBoundUs(end), `seed ${seed}: ${error} above the bound`);
  }
  errors.sort((a, b) => a - b);
  assert.ok(errors[296] <= 3000, `p99 ${errors[296]}`);
});

test('drift is found: the error stays small between exchanges that stop', () => {
  const server = (t) => t * (1 + 8e-5) + 7e10, clock = new Clock();
  const later = run(clock, { seconds: 110, delay: (r) => 1000 + 1000 * r(), server }) + 20e6;
  const error = Math.abs(clock.serverUs(later) - server(later));
  assert.ok(error < 1000, `error ${error}; without drift it would be 1600`);
});

test('a small change is slewed by at most 1 %, never backwards', () => {
  let shift = 0;
  const server = (t) => t + 1e9 + shift, clock = new Clock();
  let end = run(clock, { seconds: 10, delay: () => 500, server });
  let last = clock.serverUs(end);
  shift = -60e3;
  end = run(clock, { seconds: 3, delay: () => 500, server, from: end });
  last = clock.serverUs(end);
  for (let now = end + 16e3; now < end + 10e6; now += 16e3) {
    const shown = clock.serverUs(now), rate = (shown - last) / 16e3;
    assert.ok(rate > 0.989 && rate < 1.011, `rate ${rate}`);
    last = shown;
  }
  assert.ok(Math.abs(clock.serverUs(end + 10e6) - server(end + 10e6)) < 100);
});

test('a change above 200 ms is a step, one wild answer is none', () => {
  let shift = 0;
  const server = (t) => t + 1e9 + shift, clock = new Clock();
  let end = run(clock, { seconds: 10, delay: () => 1000, server });
  clock.observe({ t0: end, t1: server(end) + 36e8, t2: server(end) + 36e8, t3: end + 2000 });
  assert.ok(Math.abs(clock.serverUs(end) - server(end)) < 1000);
  shift = 5e6;
  end = run(clock, { seconds: 1, delay: () => 1000, server, from: end });
  assert.ok(Math.abs(clock.serverUs(end) - server(end)) < 1000);
});

test('impossible exchanges change nothing', () => {
  const clock = new Clock();
  for (const [t0, t1, t2, t3] of [[0, 0, 0, -1], [0, 10, 5, 20], [0, 0, 100, 50], [10, NaN, 6, 20], [0, 2 ** 61, 2 ** 61, 1]]) {
    assert.equal(clock.observe({ t0, t1, t2, t3 }), false);
  }
  assert.equal(clock.synced, false);
});

test('a stall does not move the clock', () => {
  const server = (t) => t + 1e9, clock = new Clock();
  let i = 0;
  const end = run(clock, { seconds: 60, server, delay: (r) => (i++ % 5 === 0 ? 3e5 * r() : 0) + 5000 + 1000 * r() });
  assert.ok(Math.abs(clock.serverUs(end) - server(end)) < 1000);
});
