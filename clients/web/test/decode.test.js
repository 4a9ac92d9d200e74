// Frames: a valid one in every field, each way of being wrong, and the vectors of the repository.

import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import test from 'node:test';
import { crc32 } from '../src/crc32.js';
import { CLASSES, decodeFrame, FrameError, GROUPS } from '../src/decode.js';
import { CHANNELS, makeFrame, seal, slowCrc } from './frames.js';

const VECTORS = new URL('../../../proto/vectors/', import.meta.url);

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
  'group': (v) => v.setUint8(9, 4),
  'codec': (v) => v.setUint8(10, 1),
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
  'zero at 22': (v) => v.setUint16(22, 1, true),
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

/** The bytes of a file in a buffer of their own, as a WebSocket would give them. */
function bytesOf(url) {
  return Uint8Array.from(readFileSync(url)).buffer;
}

function binaries(folder) {
  return existsSync(folder) ? readdirSync(folder).filter((f) => f.endsWith('.bin')) : [];
}

test('vectors of the repository', (t) => {
  const names = binaries(VECTORS);
  if (names.length === 0) return skip(t, 'no vectors in proto/vectors');
  for (const name of names) {
    const frame = decodeFrame(bytesOf(new URL(name, VECTORS)));
    const said = JSON.parse(readFileSync(new URL(name.replace('.bin', '.json'), VECTORS), 'utf8'));
    compare(name, frame, said);
  }
  return undefined;
});

test('invalid vectors of the repository', (t) => {
  const folder = new URL('invalid/', VECTORS);
  const names = binaries(folder);
  if (names.length === 0) return skip(t, 'no vectors in proto/vectors/invalid');
  for (const name of names) {
    assert.throws(() => decodeFrame(bytesOf(new URL(name, folder))), FrameError, name);
  }
  return undefined;
});

function compare(name, frame, said) {
  const header = said.header ?? said;
  const plain = { cascade: frame.cascade, level: frame.level, n: frame.n, level_n: frame.levelN, tile_x: frame.tileX,
    tile_z: frame.tileZ, channels: frame.channels, layout: frame.layout, flags: frame.flags,
    tick: String(frame.tick), sequence: String(frame.sequence) };
  for (const [field, value] of Object.entries(plain)) {
    if (field in header) assert.equal(String(header[field]), String(value), `${name}: ${field}`);
  }
  if ('epoch' in header) {
    const said64 = /^[0-9]+$/.test(header.epoch) ? [BigInt(header.epoch).toString(16).padStart(16, '0'), header.epoch] : [header.epoch];
    assert.ok(said64.includes(frame.epoch), `${name}: epoch ${header.epoch}, decoded ${frame.epoch}`);
  }
  for (const [field, value, names] of [['class', frame.class, CLASSES], ['group', frame.group, GROUPS]]) {
    if (field in header) assert.ok(header[field] === value || header[field] === names[value], `${name}: ${field}`);
  }
  for (const [field, values] of [['step', frame.step], ['max_error', frame.maxError]]) {
    if (Array.isArray(header[field])) header[field].forEach((v, i) => assert.equal(Math.fround(v), values[i], `${name}: ${field}`));
  }
  const size = frame.n * frame.n;
  const planes = said.planes ?? [];
  assert.ok(planes.length === frame.channels, `${name}: ${planes.length} planes described, ${frame.channels} sent`);
  planes.forEach((plane, c) => {
    const counts = frame.counts.subarray(c * size, (c + 1) * size);
    const full = Array.isArray(plane) ? plane : plane.counts;
    if (full) {
      assert.deepEqual([...counts], full, `${name}: plane ${c}`);
    } else {
      const copy = counts.slice();
      const crc = plane.crc32 ?? plane.crc ?? plane.counts_crc32;
      assert.equal(crc32(0, copy.buffer, 0, copy.byteLength), Number(crc), `${name}: crc of plane ${c}`);
    }
  });
}

function skip(t, why) {
  console.error(`SKIPPED: ${why}`);
  if (process.env.SWELLCAST_REQUIRE_VECTORS === '1') assert.fail(why);
  t.skip(why);
}
