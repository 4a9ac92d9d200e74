// The vectors of the repository: every frame decodes to what stands beside it, every wrong one is refused.

import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import test from 'node:test';
import { inflateRawSync } from 'node:zlib';
import { crc32 } from '../src/crc32.js';
import { decodeFrame, Decoder } from '../src/decode.js';
import { CLASSES, CODECS, FrameError, GROUPS } from '../src/frame.js';
import { split } from './streams.js';

const VECTORS = new URL('../../../proto/vectors/', import.meta.url);

/** The bytes of a file in a buffer of their own, as a WebSocket would give them. */
function bytesOf(url) {
  return Uint8Array.from(readFileSync(url)).buffer;
}

function binaries(folder, ending = '.bin') {
  return existsSync(folder) ? readdirSync(folder).filter((f) => f.endsWith(ending)) : [];
}

const inflate = (bytes, most) => inflateRawSync(bytes, { maxOutputLength: most });
const read = (name) => JSON.parse(readFileSync(new URL(name, VECTORS), 'utf8'));

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

test('streams of the repository, in the order in which they are sent', (t) => {
  const names = binaries(new URL('streams/', VECTORS), '.frames');
  if (names.length === 0) return skip(t, 'no vectors in proto/vectors/streams');
  for (const name of names) {
    const decoder = new Decoder(1 << 20, inflate);
    const said = read(`streams/${name.replace('.frames', '.json')}`).frames;
    const frames = split(readFileSync(new URL(`streams/${name}`, VECTORS)));
    assert.equal(frames.length, said.length, name);
    frames.forEach((bytes, i) => {
      const frame = decoder.decode(bytes);
      const { tick, depth, flags } = frame;
      assert.deepEqual({ tick: String(tick), depth, flags, bytes: frame.bytes, crc32: crcs(frame) }, said[i], `${name}, frame ${i}`);
      // Its memory goes back, and what was in it must not matter.
      if (frame.counts?.byteLength === frame.counts?.buffer.byteLength) {
        frame.counts?.fill(0x5555);
        if (frame.counts) decoder.recycle(frame.counts.buffer);
      }
    });
  }
  return undefined;
});

/** CRC-32 of each channel. */
function crcs({ counts, floats, channels, n }) {
  const all = counts ?? floats;
  return Array.from({ length: channels }, (_, c) => {
    const plane = all.slice(c * n * n, (c + 1) * n * n);
    return crc32(0, plane.buffer, 0, plane.byteLength);
  });
}

test('invalid vectors of the repository', (t) => {
  for (const folder of ['invalid/', 'invalid/payloads/']) {
    const names = binaries(new URL(folder, VECTORS));
    if (names.length === 0) return skip(t, `no vectors in proto/vectors/${folder}`);
    assert.deepEqual(names.sort(), read(`${folder}index.json`).map((v) => v.file).sort());
    for (const name of names) {
      const bytes = bytesOf(new URL(folder + name, VECTORS));
      assert.throws(() => new Decoder(1 << 20, inflate).decode(bytes), FrameError, name);
    }
  }
  return undefined;
});

function compare(name, frame, said) {
  const header = said.header ?? said;
  const plain = { cascade: frame.cascade, level: frame.level, n: frame.n, level_n: frame.levelN, tile_x: frame.tileX,
    tile_z: frame.tileZ, channels: frame.channels, depth: frame.depth, layout: frame.layout, flags: frame.flags,
    tick: String(frame.tick), sequence: String(frame.sequence) };
  for (const [field, value] of Object.entries(plain)) {
    if (field in header) assert.equal(String(header[field]), String(value), `${name}: ${field}`);
  }
  if ('epoch' in header) {
    const said64 = /^[0-9]+$/.test(header.epoch) ? [BigInt(header.epoch).toString(16).padStart(16, '0'), header.epoch] : [header.epoch];
    assert.ok(said64.includes(frame.epoch), `${name}: epoch ${header.epoch}, decoded ${frame.epoch}`);
  }
  for (const [field, value, names] of [['class', frame.class, CLASSES], ['group', frame.group, GROUPS],
    ['codec', frame.codec, CODECS]]) {
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
