// Headers of frames: a valid one in every field, and each way of being wrong.

import assert from 'node:assert/strict';
import test from 'node:test';
import { crc32 } from '../src/crc32.js';
import { decodeFrame } from '../src/decode.js';
import { FrameError, layerOf } from '../src/frame.js';
import { CHANNELS, makeFrame, seal, slowCrc } from './frames.js';

test('crc of the standard check string, and of every short length', () => {
  const bytes = new Uint8Array(64);
  new TextEncoder().encodeInto('123456789', bytes);
  assert.equal(crc32(0, bytes.buffer, 0, 9), 0xcbf43926);
  bytes.forEach((_, i) => { bytes[i] = i * 37; });
  for (let n = 0; n <= 60; n++) {
    assert.equal(crc32(0, bytes.buffer, 4, n), slowCrc(bytes.subarray(4, 4 + n)));
    assert.equal(crc32(crc32(0, bytes.buffer, 0, 4), bytes.buffer, 4, n), slowCrc(bytes.subarray(0, 4 + n)));
  }
});

test('a valid frame of each group, without a copy', () => {
  for (let group = 0; group < 4; group++) {
    const buffer = makeFrame({ group, n: 16, tick: Number.MAX_SAFE_INTEGER, flags: 3 });
    const frame = decodeFrame(buffer);
    assert.equal(frame.cascade, 1);
    assert.equal(frame.group, group);
    assert.equal(frame.flags, 3);
    assert.equal(frame.channels, CHANNELS[group]);
    assert.equal(frame.tick, Number.MAX_SAFE_INTEGER);
    assert.equal(frame.epoch, 'ab54a98ceb1f0ad2');
    assert.equal(frame.sequence, 3n);
    assert.equal(frame.layout, 1);
    assert.equal(frame.step[0], Math.fround(0.002));
    assert.equal(frame.maxError[0], Math.fround(0.001));
    assert.equal(frame.counts.length, CHANNELS[group] * 256);
    assert.equal(frame.counts[300 % frame.counts.length], (((300 % frame.counts.length) * 7919) % 65536) - 32768);
    assert.equal(frame.counts.buffer, buffer);
  }
});

test('a tile of a larger patch', () => {
  const frame = decodeFrame(makeFrame({ group: 3, n: 256, levelN: 512, tileX: 1, tileZ: 0 }));
  assert.deepEqual([frame.n, frame.levelN, frame.tileX, frame.tileZ], [256, 512, 1, 0]);
});

const WRONG = {
  'magic': (v) => v.setUint8(0, 0x73),
  'header_bytes': (v) => v.setUint16(4, 96, true),
  'class': (v) => v.setUint8(8, 4),
  'group': (v) => v.setUint8(9, 9),
  'codec': (v) => v.setUint8(10, 5),
  'flags': (v) => v.setUint8(11, 5),
  'n of 0': (v) => v.setUint16(12, 0, true),
  'n not a power of two': (v) => v.setUint16(12, 12, true),
  'n above 256': (v) => v.setUint16(12, 512, true),
  'level_n of 0': (v) => v.setUint16(14, 0, true),
  'level_n not a multiple': (v) => v.setUint16(14, 12, true),
  'level_n of small tiles': (v) => v.setUint16(14, 16, true),
  'tile_x': (v) => v.setUint16(16, 1, true),
  'tile_z': (v) => v.setUint16(18, 1, true),
  'channels': (v) => v.setUint16(20, 2, true),
  'zero at 23': (v) => v.setUint8(23, 1),
  'depth of counts': (v) => { v.setUint8(11, 0); v.setUint8(22, 1); },
  'tick': (v) => v.setBigUint64(24, 1n << 53n, true),
  'payload_bytes': (v) => v.setUint32(52, 386, true),
  'step of 0': (v) => v.setFloat32(56, 0, true),
  'step below 0': (v) => v.setFloat32(60, -1, true),
  'step infinite': (v) => v.setFloat32(64, Infinity, true),
  'max_error NaN': (v) => v.setFloat32(68, NaN, true),
  'zero at 84': (v) => v.setUint32(84, 1, true),
};
for (const [what, patch] of Object.entries(WRONG)) {
  test(`refused: ${what}`, () => assert.throws(() => decodeFrame(makeFrame({}, patch)), FrameError));
}

test('refused: step or max_error of an absent channel', () => {
  assert.throws(() => decodeFrame(makeFrame({ group: 3 }, (v) => v.setFloat32(60, 1, true))), FrameError);
  assert.throws(() => decodeFrame(makeFrame({ group: 1 }, (v) => v.setFloat32(76, 1, true))), FrameError);
});

test('refused: every cut, and a byte too many', () => {
  const whole = makeFrame();
  for (const size of [0, 1, 87, 88, whole.byteLength - 1]) {
    assert.throws(() => decodeFrame(whole.slice(0, size)), FrameError);
  }
  const longer = new Uint8Array(whole.byteLength + 1);
  longer.set(new Uint8Array(whole));
  seal(longer.buffer);
  assert.throws(() => decodeFrame(longer.buffer), FrameError);
});

test('refused: any flipped bit', () => {
  const whole = makeFrame();
  for (let bit = 0; bit < whole.byteLength * 8; bit += 5) {
    const bad = new Uint8Array(whole.slice(0));
    bad[bit >> 3] ^= 1 << (bit & 7);
    assert.throws(() => decodeFrame(bad.buffer), FrameError, `bit ${bit}`);
  }
});

test('depth fits flags, codec and layer', () => {
  const payload = new Uint8Array(60).fill(255); // no plane: what passes the header fails there
  const refusal = (over) => {
    try {
      decodeFrame(makeFrame({ codec: 1, payload, ...over }));
    } catch (error) {
      assert.ok(error instanceof FrameError);
      return error.message;
    }
    return assert.fail('accepted');
  };
  const [past, between, off] = [960, 240, 100];
  for (const [over, holds] of [[{ tick: past, depth: 0 }, true], [{ tick: past, depth: 3 }, true], [{ tick: past, depth: 4 }, false],
    [{ tick: between, depth: 4 }, true], [{ tick: 120, depth: 4 }, true], [{ tick: between, depth: 1 }, false],
    [{ tick: off, depth: 4 }, false], [{ tick: off, depth: 0 }, true], [{ tick: past, depth: 1, flags: 1 }, false],
    [{ tick: past, depth: 0, flags: 0 }, true], [{ tick: past, depth: 5 }, false]]) {
    assert.equal(!refusal(over).startsWith('depth'), holds, JSON.stringify(over));
  }
  assert.deepEqual([0, 480, 240, 720, 120, 360, 60].map(layerOf), [0, 0, 1, 1, 2, 2, 3]);
});

test('payloads of each codec have the lengths they can have', () => {
  const samples = 64;
  for (const [codec, lengths] of [[0, [128]], [1, [1, samples * 4 + 8192]], [2, [1, samples * 4 + 8192]], [3, [128]], [4, [256]]]) {
    const fits = (length) => {
      try {
        decodeFrame(makeFrame({ group: 3, codec, payload: new Uint8Array(length) }));
        return true;
      } catch (error) {
        return !error.message.startsWith('payload_bytes');
      }
    };
    for (const length of lengths) assert.ok(fits(length), `codec ${codec}: ${length}`);
    for (const length of [lengths[0] - 1, lengths.at(-1) + 1]) assert.ok(!fits(length), `codec ${codec}: ${length}`);
  }
});

test('max_error of floats of 32 bits is 0', () => {
  assert.throws(() => decodeFrame(makeFrame({ group: 3, codec: 4, payload: new Uint8Array(256) }, (v) => v.setFloat32(68, 1, true))), FrameError);
});
