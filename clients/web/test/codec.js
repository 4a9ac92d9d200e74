// Encodes planes for tests, as PROTOCOL.md section 10 says them: plain and slow, one sample at a time, so that the
// decoder is held to the page and not to itself.

import { deflateRawSync } from 'node:zlib';

/** Prediction of one sample: `basis` is {depth, planes}. */
function predict({ depth, planes }, taps, counts, n, x, z) {
  const at = (plane, dx, dz) => plane[((z + dz + n) % n) * n + (x + dx + n) % n];
  const [w0, w1, w2, w3, w4, w5, w6, w7] = taps;
  const dot = (...pairs) => pairs.reduce((sum, [w, v]) => (sum + Math.imul(w, v)) | 0, 0);
  if (depth === 0) {
    if (z === 0) return x === 0 ? 0 : at(counts, -1, 0) * 4096;
    if (x === 0) return at(counts, 0, -1) * 4096;
    const west = at(counts, -1, 0), north = at(counts, 0, -1);
    const northEast = x === n - 1 ? north : at(counts, 1, -1);
    const farWest = x === 1 ? west : at(counts, -2, 0), farNorth = z === 1 ? north : at(counts, 0, -2);
    return (dot([w0, west], [w1, north], [w2, at(counts, -1, -1)], [w3, northEast], [w4, farWest], [w5, farNorth]) + (Math.imul(w7, west) >> 4)) | 0;
  }
  const cross = (plane) => (dot([w0, at(plane, 0, 0)], [w1, at(plane, -1, 0)], [w2, at(plane, 1, 0)], [w3, at(plane, 0, -1)],
    [w4, at(plane, 0, 1)]) + (Math.imul(w7, at(plane, 0, 0)) >> 4)) | 0;
  if (depth === 4) return (cross(planes[0]) + cross(planes[1])) | 0;
  const older = dot([w5, planes[1] ? at(planes[1], 0, 0) : 0], [w6, planes[2] ? at(planes[2], 0, 0) : 0]);
  return (cross(planes[0]) + older) | 0;
}

export function predictions(basis, taps, counts, n) {
  return Array.from({ length: n * n }, (_, i) => predict(basis, taps, counts, n, i % n, Math.floor(i / n)));
}

function tapBytes(taps, wide = 0) {
  return Buffer.concat([Buffer.from(Int16Array.from(taps).buffer), Buffer.from([wide, 0, 0, 0])]);
}

/** The 20 bytes and the coded plane of codec 1. */
export function ransPlane(counts, basis, taps, n, { contexts = 4, shift = 0 } = {}) {
  const samples = predictions(basis, taps, counts, n).map((p, i) => {
    const r = counts[i] - (p >> 12), y = r >> shift;
    const escapes = y < -127 || y > 127;
    return { y: escapes ? -128 : y, low: r & ((1 << shift) - 1), c: contexts > 1 ? (p >> 10) & 3 : 0, escapes, count: counts[i] };
  });
  const tables = Array.from({ length: contexts }, (_, c) => sharesOf(samples.filter((s) => s.c === c)));
  const starts = tables.map((shares) => shares.reduce((sums, f) => [...sums, sums.at(-1) + f], [0]));
  const states = [32768, 32768, 32768, 32768], words = [];
  const push = (lane) => { words.unshift(states[lane] & 0xffff); states[lane] >>>= 16; };
  for (let i = samples.length - 1; i >= 0; i--) {
    const { y, low, c } = samples[i], lane = i % 4, f = tables[c][y + 128], b = starts[c][y + 128];
    if (shift > 0) {
      if (states[lane] >= 2 ** (31 - shift)) push(lane);
      states[lane] = states[lane] * 2 ** shift + low;
    }
    if (states[lane] >= f * 2 ** 21) push(lane);
    states[lane] = Math.floor(states[lane] / f) * 1024 + (states[lane] % f) + b;
  }
  const escapes = samples.filter((s) => s.escapes).map((s) => s.count);
  const table = Buffer.from(tables.flatMap(tableBytes));
  const head = Buffer.alloc(28);
  head[0] = contexts;
  head[1] = shift;
  head.writeUInt16LE(table.length + (table.length & 1), 2);
  head.writeUInt32LE(words.length, 4);
  head.writeUInt32LE(escapes.length, 8);
  states.forEach((x, lane) => head.writeUInt32LE(x, 12 + 4 * lane));
  const plane = [head, table, Buffer.alloc(table.length & 1), Buffer.from(Uint16Array.from(words).buffer), Buffer.from(Int16Array.from(escapes).buffer)];
  const size = Buffer.concat(plane).length;
  return Buffer.concat([tapBytes(taps), ...plane, Buffer.alloc((4 - size % 4) % 4)]);
}

/** 1024 slots for what comes, at least one for each. */
function sharesOf(samples) {
  const seen = new Array(256).fill(0);
  samples.forEach(({ y }) => { seen[y + 128]++; });
  if (samples.length === 0) seen[128] = 1;
  const total = Math.max(1, samples.length);
  const shares = seen.map((k) => (k === 0 ? 0 : Math.max(1, Math.round((k / total) * 1024))));
  for (let left = 1024 - shares.reduce((a, b) => a + b); left !== 0;) {
    const most = shares.indexOf(Math.max(...shares)), step = left > 0 ? left : -1;
    shares[most] += step;
    left -= step;
  }
  return shares;
}

function tableBytes(shares) {
  const first = shares.findIndex((f) => f > 0), last = shares.findLastIndex((f) => f > 0);
  const slots = shares.slice(first, last + 1).flatMap((f) => (f < 128 ? [f] : [128 | f & 127, f >> 7]));
  return [first, last - first, ...slots];
}

/** The payload of codec 2. */
export function deflatePayload(planes, bases, taps, n) {
  const heads = [], bodies = [];
  planes.forEach((counts, c) => {
    const spatial = (i) => {
      const x = i % n, z = Math.floor(i / n), at = (j, there) => (there ? counts[j] : 0);
      return at(i - 1, x > 0) + at(i - n, z > 0) - at(i - n - 1, x > 0 && z > 0);
    };
    const predicted = bases[c].depth === 0 ? Array.from(counts, (_, i) => spatial(i))
      : predictions(bases[c], taps[c], counts, n).map((p) => ((p + 2048) | 0) >> 12);
    const folded = predicted.map((q, i) => {
      const r = (counts[i] - q) << 16 >> 16;
      return (r << 1 ^ r >> 15) & 0xffff;
    });
    const wide = folded.some((u) => u > 255) ? 1 : 0;
    heads.push(tapBytes(bases[c].depth === 0 ? new Array(8).fill(0) : taps[c], wide));
    bodies.push(Buffer.from(folded.map((u) => u & 255)));
    if (wide) bodies.push(Buffer.from(folded.map((u) => u >> 8)));
  });
  return Buffer.concat([...heads, deflateRawSync(Buffer.concat(bodies))]);
}
