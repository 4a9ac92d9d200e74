// Digests of what is decoded, tick by tick: the web client's part in the test of all clients against one server.
//
// node --experimental-websocket test/digest.mjs URL SECONDS

import { crc32 } from '../src/crc32.js';
import { connect } from '../src/index.js';

const [url, seconds] = process.argv.slice(2);

/** Without reports: it is told late rather than less. */
globalThis.WebSocket = class extends WebSocket {
  send(text) {
    if (JSON.parse(text).type !== 'report') super.send(text);
  }
};

const client = connect(url, { class: '5mm', groups: ['displacement'] }, { worker: false });
client.on('state', ({ connected, detail }) => connected || console.error(`not connected: ${detail}`));
client.on('refused', (why) => console.error(`refused: ${why}`));
client.on('frame', ({ cascade, level, tick, counts }) => {
  // Coarser frames, which a busy server may send, are other ones.
  if (cascade !== client.hello.layout.cascades[0].index || level !== 0) return;
  const digest = crc32(0, counts.buffer, counts.byteOffset, counts.byteLength);
  console.log(JSON.stringify({ tick, digest: digest.toString(16).padStart(8, '0') }));
});
setTimeout(() => process.exit(0), Number(seconds) * 1000);
