// A sea that is followed, without a worker: what is held across a loss, another subscription, another layout and sea.

import assert from 'node:assert/strict';
import test, { mock } from 'node:test';
import { connect, streamOf } from '../src/client.js';
import { decodeFrame } from '../src/decode.js';
import { makeFrame } from './frames.js';
import { FakeSocket, hello, useFakeSockets } from './sockets.js';

function start(t) {
  mock.timers.enable({ apis: ['setTimeout', 'setInterval'] });
  t.after(() => mock.timers.reset());
  useFakeSockets();
  const client = connect('http://sea.example:8080/', { groups: ['displacement'] }, { worker: false }), heard = [];
  t.after(() => client.close());
  for (const kind of ['hello', 'playback', 'state', 'frame', 'message']) client.on(kind, () => heard.push(kind));
  const send = (ticks, count = 100) => ticks.forEach((tick) => {
    FakeSocket.all.at(-1).say(makeFrame({ tick, value: (i) => (Math.floor(i / 64) === 1 ? count : 0) }));
  });
  return { client, heard, send };
}

test('the stream of a server', () => {
  assert.equal(streamOf('http://h:8080'), 'ws://h:8080/v1/stream');
  assert.equal(streamOf('https://h/sea/?eye=1#x'), 'wss://h/sea/v1/stream');
  assert.equal(streamOf('wss://h/v1/stream'), 'wss://h/v1/stream');
  for (const wrong of ['h', 'localhost:8080', 'ftp://h']) assert.throws(() => streamOf(wrong), TypeError, wrong);
});

test('what is held stays over a loss and another subscription, and goes with another sea', (t) => {
  const { client, heard, send } = start(t);
  assert.ok(Number.isNaN(client.heightAt(0, 0, 4800)), 'nothing is known yet');
  FakeSocket.all[0].say(hello());
  const first = client.playback;
  send([4320, 4800, 5280]);
  assert.equal(client.heightAt(1, 1, 4900).toFixed(6), '0.200000');
  assert.deepEqual(client.sample(4900).map(({ group, n, values }) => [group, n, values[64].toFixed(6)]), [['displacement', 8, '0.200000']]);
  FakeSocket.all[0].onclose({ code: 1006, reason: '' });
  assert.equal(client.connected, false);
  mock.timers.tick(400);
  FakeSocket.all[1].say(hello());
  assert.equal(client.playback, first, 'the same sea in the same layout');
  assert.deepEqual([client.connected, client.heightAt(1, 1, 4900).toFixed(6)], [true, '0.200000']);
  client.subscribe({ rate: 30 });
  assert.notEqual(client.playback, first);
  assert.equal(client.heightAt(1, 1, 4900).toFixed(6), '0.200000', 'until more has come');
  FakeSocket.all[1].say(hello({ epoch: '00000000000000ff' }));
  assert.ok(Number.isNaN(client.heightAt(1, 1, 4900)), 'another sea');
  assert.deepEqual(heard.filter((kind) => kind === 'playback' || kind === 'hello'), ['playback', 'hello', 'hello', 'playback', 'playback', 'hello']);
  assert.deepEqual([client.counts.frames, client.counts.used, client.counts.refused], [3, 3, 0]);
});

test('a handler that asks for something else on hello is not called for ever, and can be taken off', (t) => {
  const { client } = start(t);
  let called = 0;
  const off = client.on('hello', () => {
    called++;
    client.subscribe({ level: 1 });
  });
  FakeSocket.all[0].say(hello());
  assert.deepEqual([called, client.playback.plan.units[0].level], [1, 1]);
  off();
  FakeSocket.all[0].say(hello({ sequence: 1 }));
  assert.equal(called, 1);
});

test('a group that is not known is refused by name', (t) => {
  const { client } = start(t);
  const wrong = { groups: ['displacment'] };
  assert.throws(() => connect('http://h', wrong, { worker: false }), /groups has displacment/);
  assert.throws(() => client.subscribe(wrong), /groups has displacment/);
});

test('a worker that does not start is told of', () => {
  const heard = [], worker = { postMessage() {} };
  const client = connect('http://h', {}, { worker });
  client.on('state', (state) => heard.push(state));
  worker.onerror({ message: '' });
  assert.deepEqual(heard, [{ connected: false, detail: 'the worker does not start' }]);
  client.close();
  assert.equal(worker.onmessage, null);
});

test('memory of frames goes back to the worker, unless somebody was given frames', () => {
  for (const listens of [false, true]) {
    const posted = [], worker = { postMessage: (request) => posted.push(request) };
    const client = connect('http://h', { groups: ['displacement'] }, { worker });
    const off = listens ? client.on('frame', () => {}) : () => {};
    off(); // what it was given it may hold
    const unit = { cascade: 1, level: 0, class: '1mm', group: 'displacement' };
    worker.onmessage({ data: { kind: 'hello', args: [hello(), { rateHz: 15, units: [unit] }] } });
    for (let k = 10; k < 40; k++) {
      const counts = new Int16Array(3 * 64).fill(k);
      worker.onmessage({ data: { kind: 'frame', args: [{ ...decodeFrame(makeFrame({ tick: 480 * k })), counts }] } });
    }
    const back = posted.filter(({ kind }) => kind === 'recycle').map(({ buffer }) => new Int16Array(buffer)[0]);
    assert.deepEqual(back, listens ? [] : [10, 11, 12, 13, 14, 15], 'the ring has 24');
  }
});

test('server time is by the page\'s own clock', (t) => {
  const { client } = start(t);
  assert.ok(Number.isNaN(client.tick()));
  FakeSocket.all[0].began = Math.round(performance.timeOrigin * 1000); // server time is this process's age
  FakeSocket.all[0].say(hello());
  const now = performance.now();
  assert.ok(Math.abs(client.tick(now) / 7.2 - now) < 5, `${client.tick(now) / 7.2} ms, now ${now}`);
  assert.ok(client.clockBoundMs(now) < 50);
});
