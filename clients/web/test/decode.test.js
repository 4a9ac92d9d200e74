// The codecs, against an encoder written from the page alone; and what a decoder keeps, and for how long.

import assert from 'node:assert/strict';
import test from 'node:test';
import { inflateRawSync } from 'node:zlib';
import { Decoder, decodeFrame } from '../src/decode.js';
import { FrameError, MissingError, PayloadError } from '../src/frame.js';
import { deflatePayload, ransPlane } from './codec.js';
import { makeFrame, randomFrom } from './frames.js';

const RANS = 1, DEFLATE = 2;
const inflate = (bytes, most) => inflateRawSync(bytes, { maxOutputLength: most });

/** A plane of waves that move, and some noise. */
function plane(n, tick, { height = 300, noise = 3, seed = 1 } = {}) {
  const random = randomFrom(seed * 7919 + tick);
  return Int16Array.from({ length: n * n }, (_, i) => {
    const x = i % n, z = Math.floor(i / n), turn = (2 * Math.PI) / n;
    return height * (Math.sin(turn * (2 * x + z) + tick / 900) + Math.cos(turn * (3 * z - x) - tick / 700)) + noise * (random() - 0.5);
  });
}

const TAPS = {
  0: [3900, 3800, -3700, 60, -20, 40, 0, 900],
  1: [4100, 5, -7, 3, 2, 0, 0, -1200],
  2: [7900, 90, 80, -70, 30, -4000, 0, 77],
  3: [12000, 10, 20, 30, 40, -12100, 4090, -5],
  4: [2040, 3, 2, -1, 4, 0, 0, 123],
};

/** A 60 Hz stream in the order in which it is sent: [tick, depth], and what each is predicted from. */
const ORDER = [[7200, 0], [7680, 1], [7440, 4], [7320, 4], [7560, 4], [8160, 2], [7920, 4], [7800, 4], [8040, 4], [8640, 3], [8400, 4]];
function references(tick, depth) {
  if (depth === 4) return tick % 240 === 0 ? [tick - 240, tick + 240] : [tick - 120, tick + 120];
  return [480, 960, 1440].slice(0, depth).map((back) => tick - back);
}

/** Frames of foam (one channel) or slopes (two), and their counts. */
function stream(codec, n, { group = 3, look = {}, options = {}, taps = TAPS } = {}) {
  const channels = group === 1 ? 2 : 1, counts = new Map();
  return ORDER.map(([tick, depth]) => {
    counts.set(tick, Array.from({ length: channels }, (_, c) => plane(n, tick, { ...look, seed: c + 1 })));
    const bases = counts.get(tick).map((_, c) => {
      const planes = references(tick, depth).map((t) => counts.get(t)[c]);
      return { depth, planes: [planes[0] ?? null, planes[1] ?? null, planes[2] ?? null] };
    });
    const own = counts.get(tick);
    const payload = codec === DEFLATE ? deflatePayload(own, bases, own.map(() => taps[depth]), n)
      : Buffer.concat(own.map((plane, c) => ransPlane(plane, bases[c], taps[depth], n, options)));
    return { tick, depth, counts: own, bytes: makeFrame({ group, codec, n, tick, depth, payload }) };
  });
}

function check(decoder, frames) {
  for (const { tick, depth, counts, bytes } of frames) {
    const frame = decoder.decode(bytes);
    counts.forEach((plane, c) => {
      const got = frame.counts.subarray(c * plane.length, (c + 1) * plane.length);
      assert.ok(got.every((v, i) => v === plane[i]), `tick ${tick}, depth ${depth}, channel ${c}`);
    });
  }
}

for (const [name, n, given] of [
  ['one table', 16, { options: { contexts: 1 } }],
  ['four tables', 64, {}],
  ['two channels, each predicted from its own past', 32, { group: 1 }],
  ['low bits apart', 16, { look: { height: 14000 }, options: { contexts: 1, shift: 5 } }],
  ['most low bits', 8, { look: { height: 16000, noise: 4000 }, options: { contexts: 1, shift: 8 } }],
  ['escapes', 32, { look: { noise: 600 } }],
  ['escapes and low bits', 32, { look: { noise: 9000 }, options: { contexts: 1, shift: 2 } }],
  ['nothing but escapes', 16, { look: { height: 15000 }, taps: { ...TAPS, 0: [0, 0, 0, 0, 0, 0, 0, 0], 3: [1, 0, 0, 0, 0, 0, 0, 0] } }],
  ['still water', 64, { look: { height: 0, noise: 0 } }],
  ['sums that wrap', 16, { look: { height: 16000 }, taps: Object.fromEntries([0, 1, 2, 3, 4].map((d) => [d, [32767, 32767, 32767, -32768, 32767, 32767, -32768, 32767]])) }],
]) {
  test(`rans: ${name}`, () => check(new Decoder(1 << 16), stream(RANS, n, given)));
}

test('rans: random taps, counts and tables', () => {
  const random = randomFrom(77);
  for (let round = 0; round < 40; round++) {
    const n = [8, 16, 32][round % 3], shift = round % 4 === 0 ? 1 + Math.floor(random() * 8) : 0;
    const any = (size) => Math.round((random() - 0.5) * size);
    const taps = Object.fromEntries([0, 1, 2, 3, 4].map((d) => [d, Array.from({ length: 8 }, () => any(round % 2 ? 65534 : 3000))]));
    const look = { height: random() * 16000, noise: random() ** 4 * 20000 };
    check(new Decoder(1 << 16), stream(RANS, n, { look, taps, options: { contexts: shift || round % 5 === 0 ? 1 : 4, shift } }));
  }
});

for (const [name, n, given] of [
  ['bytes', 16, { look: { height: 20, noise: 1 } }],
  ['two bytes', 32, { group: 1, look: { height: 9000, noise: 900 } }],
  ['all the range', 16, { look: { height: 16000, noise: 2000 } }],
]) {
  test(`deflate: ${name}`, () => check(new Decoder(1 << 16, inflate), stream(DEFLATE, n, given)));
}

test('deflate without inflate is refused', () => {
  assert.throws(() => new Decoder(1 << 16).decode(stream(DEFLATE, 8)[0].bytes), PayloadError);
});

test('floats', () => {
  const values = Float32Array.from({ length: 64 }, (_, i) => (i - 31.5) / 16);
  const whole = decodeFrame(makeFrame({ group: 3, codec: 4, payload: new Uint8Array(values.buffer) }));
  assert.deepEqual([whole.floats, whole.counts], [values, null]);
  const halves = Uint16Array.from({ length: 64 }, (_, i) => [0, 0x8000, 1, 0x3ff, 0x400, 0x3c00, 0xc000, 0x7bff][i % 8]);
  const half = decodeFrame(makeFrame({ group: 3, codec: 3, payload: new Uint8Array(halves.buffer) }));
  assert.deepEqual([...half.floats.subarray(0, 8)], [0, -0, 2 ** -24, 1023 * 2 ** -24, 2 ** -14, 1, -2, 65504]);
  for (const bits of [0x7c00, 0xfc00, 0xfe00]) {
    halves[63] = bits;
    assert.throws(() => decodeFrame(makeFrame({ group: 3, codec: 3, payload: new Uint8Array(halves.buffer) })), PayloadError);
  }
});

test('references that are missing are said to be', () => {
  const frames = stream(RANS, 8);
  assert.throws(() => new Decoder(1 << 16).decode(frames[1].bytes), MissingError);
  for (const left of [0, 1, 5]) {
    const decoder = new Decoder(1 << 16);
    frames.slice(0, 9).forEach((f, i) => {
      if (i !== left) try { decoder.decode(f.bytes); } catch (error) { assert.ok(error instanceof MissingError); }
    });
    assert.throws(() => decoder.decode(frames[9].bytes), MissingError, `without frame ${left}`);
  }
  const decoder = new Decoder(1 << 16);
  check(decoder, [frames[0], frames[1]]);
  assert.throws(() => decoder.decode(frames[3].bytes), MissingError, 'the frame halfway is not there');
  check(decoder, frames.slice(2, 6));
});

test('another epoch, size, unit or tile has nothing to do with it', () => {
  const [key, next] = stream(RANS, 16);
  const other = (over) => {
    const bytes = next.bytes.slice(0);
    return makeFrame({ group: 3, codec: RANS, n: 16, tick: next.tick, depth: 1, payload: new Uint8Array(bytes, 88), ...over });
  };
  for (const over of [{ epoch: 5n }, { cascade: 2 }, { level: 1 }, { class: 2 }, { group: 4 }, { n: 8 }]) {
    const decoder = new Decoder(1 << 16);
    decoder.decode(key.bytes);
    assert.throws(() => decoder.decode(other(over)), MissingError, Object.keys(over)[0]);
    decoder.decode(next.bytes);
  }
});

test('what was handed over is no part of what is kept', () => {
  const frames = stream(RANS, 16), decoder = new Decoder(1 << 16);
  for (const f of frames) decoder.decode(f.bytes).counts.fill(7);
  check(decoder, frames);
});

test('a frame that is damaged changes nothing', () => {
  const frames = stream(RANS, 16), decoder = new Decoder(1 << 16);
  frames.forEach((f) => {
    const random = randomFrom(f.tick);
    for (let i = 0; i < 200; i++) {
      const payload = new Uint8Array(f.bytes.slice(88));
      payload[Math.floor(random() * payload.length)] ^= 1 << Math.floor(random() * 8);
      const bytes = makeFrame({ group: 3, codec: RANS, n: 16, tick: f.tick, depth: f.depth, payload });
      // A wrong tap or escape is another frame: only a checksum tells. It must not be kept.
      try { new Decoder(1 << 16).decode(bytes); } catch (error) { assert.ok(error instanceof FrameError); }
    }
    const cut = makeFrame({ group: 3, codec: RANS, n: 16, tick: f.tick, depth: f.depth, payload: new Uint8Array(f.bytes.slice(88, -4)) });
    assert.throws(() => decoder.decode(cut), PayloadError);
    check(decoder, [f]);
  });
});

test('memory is bounded: units beyond what was asked for can not be predicted from', () => {
  const [key, next] = stream(RANS, 16), decoder = new Decoder(3 * 256);
  const as = (f, cascade) => makeFrame({ cascade, group: 3, codec: RANS, n: 16, tick: f.tick, depth: f.depth, payload: new Uint8Array(f.bytes.slice(88)) });
  for (let cascade = 0; cascade < 5; cascade++) decoder.decode(as(key, cascade));
  const readable = [0, 1, 2, 3, 4].filter((cascade) => {
    try { decoder.decode(as(next, cascade)); return true; } catch { return false; }
  });
  assert.deepEqual(readable, [0, 1, 2]);
  decoder.retain((unit) => unit.cascade !== 1);
  assert.throws(() => decoder.decode(as(next, 1)), MissingError);
  decoder.decode(as(key, 4));
  decoder.decode(as(next, 4));
});
