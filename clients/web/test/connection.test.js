// The connection against a socket that is no socket: order of messages, refusals, coming back.

import assert from 'node:assert/strict';
import test, { mock } from 'node:test';
import { Connection } from '../src/connection.js';
import { ransPlane } from './codec.js';
import { makeFrame } from './frames.js';
import { CASCADE, FakeSocket, hello, useFakeSockets } from './sockets.js';

function start(t) {
  mock.timers.enable({ apis: ['setTimeout', 'setInterval'] });
  t.after(() => mock.timers.reset());
  useFakeSockets();
  const heard = [];
  const note = (name) => (...args) => heard.push([name, ...args]);
  let now = 0;
  const on = Object.fromEntries(['state', 'hello', 'plan', 'message', 'frame', 'refused', 'exchange', 'report'].map((n) => [n, note(n)]));
  const connection = new Connection('ws://h/v1/stream', { rate: 15, level: 0, class: '1mm', codec: 'rans' }, on, () => now);
  connection.open();
  return { connection, heard, pass: (ms) => { now += ms; mock.timers.tick(ms); }, names: () => heard.map((h) => h[0]) };
}

test('after hello it subscribes and exchanges time', (t) => {
  const { heard, pass } = start(t);
  const [socket] = FakeSocket.all;
  assert.equal(socket.protocol, 'swellcast.v1');
  assert.deepEqual(socket.sent, []);
  socket.say(hello());
  assert.deepEqual(socket.sent.map((m) => m.type), ['subscribe', 'time']);
  assert.equal(socket.sent[0].units.length, 4);
  assert.deepEqual(Object.keys(socket.sent[0]).sort(), ['id', 'rate_hz', 'type', 'units']);
  assert.ok(socket.sent[0].units.every((u) => u.codec === 'rans'));
  pass(100);
  assert.equal(socket.sent.length, 3);
  socket.say({ type: 'time', t0: 0, t1_us: 5000, t2_us: 5100 });
  assert.deepEqual(heard.at(-1), ['exchange', { t0: 0, t1: 5000, t2: 5100, t3: 100_000 }]);
  socket.say({ type: 'time', t0: 0, t1_us: 5000, t2_us: 5100 });
  socket.say({ type: 'time', t0: 3, t1_us: 5000, t2_us: 5100 });
  assert.equal(heard.filter((h) => h[0] === 'exchange').length, 1, 'an answer that was not asked for');
});

test('frames pass, broken ones are refused and the connection goes on', (t) => {
  const { names } = start(t);
  const [socket] = FakeSocket.all;
  socket.say(makeFrame()); // before hello: not known what it is
  socket.say(hello());
  socket.say(makeFrame());
  socket.say(makeFrame({}, (v) => v.setUint8(10, 9)));
  socket.say('{');
  socket.say({ type: 'novelty' });
  assert.deepEqual(names(), ['hello', 'state', 'frame', 'refused', 'refused']);
  assert.equal(socket.closed, false);
});

test('frames of another sea are ignored', (t) => {
  const { connection, names, pass } = start(t);
  const [first] = FakeSocket.all;
  first.say(hello());
  first.say(makeFrame({ epoch: 7n, tick: 960_000 }));
  assert.equal(first.closed, false);
  assert.equal(connection.fares.newest, 0, 'nor do they count');
  first.say(makeFrame());
  assert.deepEqual(names(), ['hello', 'state', 'frame']);
  connection.restart('enough');
  assert.equal(first.closed, true);
  first.say(makeFrame()); // what was still under way
  pass(1000);
  const [, second, ...more] = FakeSocket.all;
  assert.deepEqual(more, []);
  second.say(hello({ epoch: '0000000000000007' }));
  second.say(makeFrame());
  second.say(makeFrame({ epoch: 7n }));
  assert.deepEqual(names().slice(3), ['state', 'hello', 'state', 'frame']);
});

test('a further hello: it subscribes to old and new, and takes frames of each at their ticks', (t) => {
  const { heard, names, pass } = start(t);
  const [socket] = FakeSocket.all;
  socket.say(hello());
  pass(100);
  const sent = socket.sent.length;
  const changing = hello({ layout: { generation: 2, cascades: [CASCADE] } });
  changing.layout.cascades = [{ ...CASCADE, until_tick: 72_000 }, { ...CASCADE, index: 8, from_tick: 36_000 }];
  socket.say(changing);
  assert.deepEqual(socket.sent.slice(sent).map((m) => m.type), ['subscribe'], 'time goes on as it did');
  assert.deepEqual(socket.sent.at(-1).units.map((u) => u.cascade), [1, 8, 1, 8, 1, 8, 1, 8]);
  const before = names().length;
  for (const [cascade, tick] of [[1, 71_520], [8, 36_000], [8, 144_000]]) socket.say(makeFrame({ cascade, tick }));
  assert.deepEqual(heard.slice(before).map((h) => [h[0], h[1].cascade]), [['frame', 1], ['frame', 8], ['frame', 8]]);
  for (const [cascade, tick] of [[1, 72_000], [8, 35_520], [0, 36_000]]) socket.say(makeFrame({ cascade, tick }));
  assert.equal(names().length, before + 3, 'dropped without a word');
  assert.equal(socket.closed, false);
});

test('lost again and again: waits grow', (t) => {
  const { pass } = start(t);
  for (let i = 0; i < 6; i++) {
    FakeSocket.all.at(-1).onclose({ code: 1006, reason: '' });
    pass(6000);
  }
  assert.equal(FakeSocket.all.length, 7);
  FakeSocket.all.at(-1).onclose({ code: 1006, reason: '' });
  pass(2200);
  assert.equal(FakeSocket.all.length, 7, 'no sooner than 2.25 s by now');
});

test('a silent server is left', (t) => {
  const { pass } = start(t);
  FakeSocket.all[0].say(hello());
  for (let i = 0; i < 9; i++) pass(1000);
  assert.equal(FakeSocket.all[0].closed, true);
});

test('a hidden page takes no frames', (t) => {
  const { connection } = start(t);
  const [socket] = FakeSocket.all;
  socket.say(hello());
  connection.pause(true);
  assert.deepEqual(socket.sent.at(-1).units, []);
  connection.pause(false);
  assert.equal(socket.sent.at(-1).units.length, 4);
  assert.ok(socket.sent.at(-1).id > socket.sent[0].id);
});

/** A predicted frame of foam: still water. */
function still(tick, depth) {
  const zero = new Int16Array(64), planes = Array.from({ length: 3 }, (_, i) => (i < depth ? zero : null));
  const payload = ransPlane(zero, { depth, planes }, [4096, 0, 0, 0, 0, 0, 0, 0], 8, { contexts: 1 });
  return makeFrame({ group: 3, codec: 1, tick, depth, payload });
}

const UNIT = { cascade: 1, level: 0, class: '1mm', group: 'foam', codec: 'rans' };
const subscribed = (...units) => ({ type: 'subscribed', id: 1, rate_hz: 15, units, from_tick: 0 });

test('once a second it reports how it fares', (t) => {
  const { heard, pass } = start(t);
  const [socket] = FakeSocket.all;
  socket.say(hello());
  socket.say({ type: 'time', t0: 0, t1_us: 1e6, t2_us: 1e6 });
  const reports = () => socket.sent.filter((m) => m.type === 'report');
  pass(1000);
  assert.deepEqual(reports(), [], 'nothing to tell');
  socket.say(subscribed(UNIT));
  socket.say(still(14_400, 0));
  socket.say(still(14_880, 1));
  pass(1000);
  const [{ buffer_ms: buffer, ...report }, ...more] = reports();
  assert.deepEqual([report, more], [{ type: 'report', tick: 14_880, decode_ms: 0 }, []]);
  assert.ok(Math.abs(buffer - (14_880 / 7.2 - 3000)) < 1e-6);
  assert.deepEqual(heard.at(-1)[0], 'report');
  socket.say(subscribed());
  pass(1000);
  assert.equal(reports().length, 1, 'another subscription: nothing to tell yet');
});

test('what can not be read is said, once a second at most', (t) => {
  const { heard, names, pass } = start(t);
  const [socket] = FakeSocket.all;
  socket.say(hello());
  socket.say(subscribed(UNIT));
  const lost = () => socket.sent.filter((m) => m.lost);
  socket.say(still(960, 2));
  assert.deepEqual(lost(), [{ type: 'report', tick: 0, decode_ms: 0, buffer_ms: 0, lost: true }]);
  socket.say(still(1440, 3));
  socket.say(still(1920, 0));
  socket.say(still(2400, 1));
  assert.equal(lost().length, 1);
  assert.deepEqual(names(), ['hello', 'state', 'message', 'report', 'refused', 'frame', 'frame']);
  assert.match(heard.find((h) => h[0] === 'refused')[1], /not held/);
  pass(1000);
  socket.say(still(4800, 2));
  assert.equal(lost().length, 2);
  socket.say(makeFrame({}, (v) => v.setUint8(10, 9)));
  pass(1000);
  socket.say(makeFrame({}, (v) => v.setUint8(10, 9)));
  assert.equal(lost().length, 2, 'a frame of another protocol: a new beginning would change nothing');
});

test('units that were not granted again are forgotten', (t) => {
  const { names } = start(t);
  const [socket] = FakeSocket.all;
  socket.say(hello());
  socket.say(subscribed(UNIT));
  socket.say(still(480, 0));
  socket.say(subscribed({ ...UNIT, group: 'slopes' }, UNIT));
  socket.say(still(960, 1));
  socket.say(subscribed({ ...UNIT, class: '5mm' }));
  socket.say(still(1440, 2));
  assert.deepEqual(names().filter((name) => name === 'frame' || name === 'refused'), ['frame', 'frame', 'refused']);
});

test('something else is asked for on the same connection, and again after a loss', (t) => {
  const { connection, heard, pass } = start(t);
  connection.subscribe({ rate: 15, level: 0, class: '1mm', codec: 'i16', groups: ['displacement'] });
  assert.deepEqual(heard, [], 'not connected yet');
  FakeSocket.all[0].say(hello());
  const units = (socket) => socket.sent.filter((m) => m.type === 'subscribe').at(-1).units.map((u) => [u.group, u.codec]);
  assert.deepEqual(units(FakeSocket.all[0]), [['displacement', 'i16']]);
  connection.subscribe({ rate: 15, level: 0, class: '1mm', codec: 'rans', groups: ['height', 'slopes'] });
  assert.deepEqual(units(FakeSocket.all[0]), [['slopes', 'rans']], 'of what is offered');
  assert.deepEqual(heard.at(-1)[0], 'plan');
  FakeSocket.all[0].onclose({ code: 1006, reason: '' });
  pass(400);
  FakeSocket.all[1].say(hello());
  assert.deepEqual(units(FakeSocket.all[1]), [['slopes', 'rans']]);
});

test('a connection that fails without a close is tried again; one that was closed is not', (t) => {
  const { connection, names, pass } = start(t);
  FakeSocket.all[0].readyState = 3;
  FakeSocket.all[0].onerror();
  pass(1);
  assert.deepEqual(names(), ['state']);
  pass(400);
  assert.equal(FakeSocket.all.length, 2);
  connection.close();
  FakeSocket.all[1].onclose({ code: 1000, reason: '' });
  pass(60_000);
  assert.deepEqual([FakeSocket.all.length, FakeSocket.all[1].closed, names().length], [2, true, 1]);
});
