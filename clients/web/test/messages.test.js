// Text messages: what is read, what is ignored, what is refused; and what is asked for.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import test from 'node:test';
import { MessageError, parseServerMessage, reportMessage, subscribeMessage, timeMessage } from '../src/messages.js';
import { readOptions } from '../viewer/options.js';
import { beaufort, compassPoint, seaTime } from '../viewer/panel.js';
import { planUnits } from '../src/plan.js';

const HELLO = {
  type: 'hello', protocol: 1, server: 's', scene: 'default', epoch: '0123456789abcdef', seed: '1', ticks_per_second: 7200,
  tick: 1, lead_ticks: 1680, sequence: 0, choppiness: 1, foam_step_ticks: 720,
  layout: { generation: 1, cascades: [0, 1].map((i) => ({ index: i, patch_m: 100 + i, n: 256, levels: 2, wavelength_min_m: 1, wavelength_max_m: 9, from_tick: 0, until_tick: null })) },
  rates_hz: [5, 15, 30], classes: [{ name: '0.5mm' }, { name: '1mm' }],
  groups: ['displacement', 'slopes', 'derivatives', 'foam'].map((name) => ({ name, channels: [] })),
  limits: { message_bytes: 4096, units: 64, live_units: 64 },
};

test('a hello, with fields nobody knows', () => {
  assert.equal(parseServerMessage(JSON.stringify({ ...HELLO, novel: 1 })).epoch, HELLO.epoch);
});

test('unknown types are ignored', () => {
  assert.equal(parseServerMessage('{"type":"weather"}'), null);
  assert.equal(parseServerMessage('{"type":"constructor"}'), null);
});

test('refused', () => {
  for (const bad of ['', '[]', '{', '{"type":1}', '{"type":"time","t0":1}', '{"type":"quality","rate_hz":0,"coarser":0}', '{"type":"quality","rate_hz":15}',
    JSON.stringify({ ...HELLO, protocol: 2 }), JSON.stringify({ ...HELLO, epoch: 'xyz' }),
    JSON.stringify({ ...HELLO, layout: null }), JSON.stringify({ ...HELLO, rates_hz: [] })]) {
    assert.throws(() => parseServerMessage(bad), MessageError, bad);
  }
});

test('messages of the repository', (t) => {
  const file = new URL('../../../proto/vectors/messages.json', import.meta.url);
  if (!existsSync(file)) {
    console.error('SKIPPED: no proto/vectors/messages.json');
    if (process.env.SWELLCAST_REQUIRE_VECTORS === '1') assert.fail('no proto/vectors/messages.json');
    t.skip('no vectors');
    return;
  }
  const all = JSON.parse(readFileSync(file, 'utf8'));
  const known = new Set(['hello', 'subscribed', 'quality', 'status', 'change', 'error']);
  let read = 0;
  const visit = (value) => {
    if (value === null || typeof value !== 'object') return;
    if (known.has(value.type) || (value.type === 'time' && 't1_us' in value)) {
      assert.equal(parseServerMessage(JSON.stringify(value)).type, value.type);
      read++;
    } else {
      for (const inner of Object.values(value)) visit(typeof inner === 'string' && inner.startsWith('{') ? JSON.parse(inner) : inner);
    }
  };
  visit(all);
  assert.ok(read > 0, 'no message of the server found');
});

test('what is sent', () => {
  assert.deepEqual(JSON.parse(timeMessage(1.5)), { type: 'time', t0: 1.5 });
  assert.deepEqual(JSON.parse(subscribeMessage(7, 15, [])), { type: 'subscribe', id: 7, rate_hz: 15, units: [] });
  const report = { tick: 480, decode_ms: 1.5, buffer_ms: -3 };
  assert.deepEqual(JSON.parse(reportMessage(report, false)), { type: 'report', ...report });
  assert.deepEqual(JSON.parse(reportMessage(report, true)), { type: 'report', ...report, lost: true });
});

test('the plan fits what is offered', () => {
  const plan = planUnits(HELLO, { rate: 14, level: 9, class: '1mm' });
  assert.equal(plan.rateHz, 15);
  assert.equal(plan.units.length, 8);
  assert.ok(plan.units.every((u) => u.level === 1 && u.class === '1mm' && u.codec === 'rans'));
  assert.ok(planUnits(HELLO, { rate: 15, level: 0, class: '1mm', codec: 'i16' }).units.every((u) => u.codec === 'i16'));
  assert.ok(planUnits(HELLO, { rate: 15, level: 0, class: '1mm', codec: 'deflate' }).units.every((u) => u.codec === 'rans'), 'not read here');
  const few = planUnits({ ...HELLO, limits: { units: 3 } }, { rate: 15, level: 0, class: 'none' });
  assert.deepEqual(few.units.map((u) => u.group), ['displacement', 'displacement', 'slopes']);
  assert.equal(few.units[0].class, '0.5mm');
});

test('a plan for two layouts at once fits into one message, what moves first', () => {
  const cascades = Array.from({ length: 16 }, (_, index) => ({ ...HELLO.layout.cascades[0], index }));
  const plan = planUnits({ ...HELLO, limits: { units: 64, message_bytes: 2048 }, layout: { generation: 3, cascades } }, { rate: 15, level: 0, class: '1mm' });
  assert.ok(subscribeMessage(1, plan.rateHz, plan.units).length <= 2048);
  assert.ok(plan.units.length > 22 && plan.units.length < 30, `${plan.units.length}`);
  assert.deepEqual(plan.units.slice(0, 16).map((u) => [u.cascade, u.group]), cascades.map((c) => [c.index, 'displacement']));
});

test('a plan keeps within what a cascade has', () => {
  const detail = [{ group: 'displacement', finest_level: 1, rate_hz: 15 }, { group: 'foam', finest_level: 0, rate_hz: 0 }];
  const [first, second] = HELLO.layout.cascades;
  const layout = { generation: 1, cascades: [first, { ...second, detail }] };
  const { units } = planUnits({ ...HELLO, layout }, { rate: 30, level: 0, class: '1mm' });
  const of = (cascade, group) => units.find((u) => u.cascade === cascade && u.group === group);
  assert.deepEqual([of(0, 'displacement').level, of(0, 'displacement').rate_hz], [0, undefined]);
  assert.deepEqual([of(1, 'displacement').level, of(1, 'displacement').rate_hz], [1, 15]);
  assert.deepEqual([of(1, 'slopes').level, of(1, 'foam')], [0, undefined]);
});

test('options', () => {
  const o = readOptions('?rate=5&eye=1,2,3&look=bad&still=1&class=5mm&ripples=0');
  assert.deepEqual([o.rate, o.eye, o.look.length, o.still, o.class, o.ripples], [5, [1, 2, 3], 2, true, '5mm', false]);
  assert.equal(readOptions('').rate, 15);
});

test('words of the panel', () => {
  assert.deepEqual([0, 0.3, 5.4, 12, 40].map(beaufort), [0, 1, 3, 6, 12]);
  assert.deepEqual([0, 359, 90, 250, -45].map(compassPoint), ['N', 'N', 'E', 'WSW', 'NW']);
  assert.equal(seaTime(7200 * 3725), '1:02:05');
});
