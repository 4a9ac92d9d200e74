// CRC-32 (IEEE 802.3, as zlib), eight bytes a step.

const TABLES = makeTables();

function makeTables() {
  const tables = new Int32Array(8 * 256);
  for (let byte = 0; byte < 256; byte++) {
    let crc = byte;
    for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
    tables[byte] = crc;
  }
  for (let i = 256; i < tables.length; i++) {
    tables[i] = (tables[i - 256] >>> 8) ^ tables[tables[i - 256] & 255];
  }
  return tables;
}

/**
 * Continues a CRC over more bytes.
 * @param {number} crc what an earlier call returned, 0 to begin
 * @param {ArrayBuffer} buffer
 * @param {number} offset where to begin, a multiple of 4
 * @param {number} length how many bytes
 * @returns {number} an unsigned 32-bit number
 */
export function crc32(crc, buffer, offset, length) {
  const pairs = length >>> 3;
  let c = ofPairs(~crc, new Int32Array(buffer, offset, pairs * 2));
  const rest = new Uint8Array(buffer, offset + pairs * 8, length & 7);
  for (let i = 0; i < rest.length; i++) c = (c >>> 8) ^ TABLES[(c ^ rest[i]) & 255];
  return ~c >>> 0;
}

/**
 * The loop by itself: an engine that compiles it while it runs has nothing behind it to guess.
 * @param {number} crc
 * @param {Int32Array} words
 */
function ofPairs(crc, words) {
  const t = TABLES;
  let c = crc;
  for (let i = 0; i < words.length; i += 2) {
    const a = words[i] ^ c;
    const b = words[i + 1];
    c = t[1792 + (a & 255)] ^ t[1536 + ((a >>> 8) & 255)] ^ t[1280 + ((a >>> 16) & 255)] ^ t[1024 + (a >>> 24)]
      ^ t[768 + (b & 255)] ^ t[512 + ((b >>> 8) & 255)] ^ t[256 + ((b >>> 16) & 255)] ^ t[b >>> 24];
  }
  return c;
}
