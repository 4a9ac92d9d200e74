// Digests of what is decoded, tick by tick: the web client's part in the test of all clients against one server.
//
// node --experimental-websocket test/digest.mjs URL SECONDS

import { Connection } from '../src/connection.js';
import { crc32 } from '../src/crc32.js';

const [url, seconds] = process.argv.slice(2);
const stream = new URL('v1/stream', url);
stream.protocol = stream.protocol === 'https:' ? 'wss:' : 'ws:';
let first = null;

const on = {
  state: (connected, detail) => connected || console.error(`not connected: ${detail}`),
  hello: (hello) => { first = hello.layout.cascades[0].index; },
  message() {},
  exchange() {},
  report() {},
  refused: (why) => console.error(`refused: ${why}`),
  frame({ cascade, group, level, tick, counts }) {
    // Group 0 is displacement; coarser frames, which a busy server may send, are other ones.
    if (cascade !== first || group !== 0 || level !== 0) return;
    const digest = crc32(0, counts.buffer, counts.byteOffset, counts.byteLength);
    console.log(JSON.stringify({ tick, digest: digest.toString(16).padStart(8, '0') }));
  },
};

new Connection(stream.href, { rate: 15, level: 0, class: '5mm', codec: 'rans' }, on, () => performance.now()).open();
setTimeout(() => process.exit(0), Number(seconds) * 1000);
