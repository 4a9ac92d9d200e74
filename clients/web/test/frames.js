// Builds frames for tests, straight from the table in PROTOCOL.md section 5; its CRC is the slow, obvious one.

/** CRC-32 by bits. */
export function slowCrc(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let i = 0; i < 8; i++) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return ~crc >>> 0;
}

export const CHANNELS = [3, 2, 3, 1, 1, 3, 2, 2, 2];

/**
 * @returns {ArrayBuffer} a valid frame but for what `over` says, of counts or of the `payload` given; `patch(view)` edits
 *   it before the CRC is set
 */
export function makeFrame(over = {}, patch = () => {}) {
  const f = { cascade: 1, level: 0, class: 1, group: 0, codec: 0, flags: over.depth ? 0 : 1, depth: 0, n: 8, tick: 7200, epoch: 0xab54a98ceb1f0ad2n,
    sequence: 3n, layout: 1, tileX: 0, tileZ: 0, ...over };
  const channels = CHANNELS[f.group];
  const payload = f.payload?.length ?? channels * f.n * f.n * 2;
  const buffer = new ArrayBuffer(88 + payload);
  const v = new DataView(buffer);
  [...'SWF1'].forEach((c, i) => v.setUint8(i, c.charCodeAt(0)));
  v.setUint16(4, 88, true);
  v.setUint8(6, f.cascade);
  v.setUint8(7, f.level);
  v.setUint8(8, f.class);
  v.setUint8(9, f.group);
  v.setUint8(10, f.codec);
  v.setUint8(11, f.flags);
  v.setUint16(12, f.n, true);
  v.setUint16(14, f.levelN ?? f.n, true);
  v.setUint16(16, f.tileX, true);
  v.setUint16(18, f.tileZ, true);
  v.setUint16(20, channels, true);
  v.setUint8(22, f.depth);
  v.setBigUint64(24, BigInt(f.tick), true);
  v.setBigUint64(32, f.epoch, true);
  v.setBigUint64(40, f.sequence, true);
  v.setUint32(48, f.layout, true);
  v.setUint32(52, payload, true);
  for (let c = 0; c < channels; c++) {
    v.setFloat32(56 + 4 * c, 0.002, true);
    v.setFloat32(68 + 4 * c, f.codec === 4 ? 0 : 0.001, true);
  }
  if (f.payload) {
    new Uint8Array(buffer, 88).set(f.payload);
  } else {
    const counts = new Int16Array(buffer, 88);
    for (let i = 0; i < counts.length; i++) counts[i] = f.value ? f.value(i) : ((i * 7919) % 65536) - 32768;
  }
  patch(v);
  seal(buffer);
  return buffer;
}

export function seal(buffer) {
  const bytes = new Uint8Array(buffer);
  const crc = slowCrc([...bytes.subarray(0, 80), ...bytes.subarray(88)]);
  new DataView(buffer).setUint32(80, crc, true);
}

/** A repeatable random number, 0 to 1. */
export function randomFrom(seed) {
  let s = seed >>> 0;
  return () => {
    s = (Math.imul(s, 1664525) + 1013904223) >>> 0;
    return ((s ^ (s >>> 13)) >>> 0) / 4294967296;
  };
}
