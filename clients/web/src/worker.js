// The network's thread: the connection and the decoder live here, so that drawing never delays a
// time exchange and a burst of frames never delays drawing. Times are sent since the page epoch.

import { Connection } from './connection.js';

/**
 * @typedef {import('./connection.js').Listener} Listener
 * @typedef {import('./plan.js').Wish} Wish
 * @typedef {{kind: 'open', url: string, wish: Wish} | {kind: 'subscribe', wish: Wish}
 *   | {kind: 'pause', paused: boolean} | {kind: 'close'}
 *   | {kind: 'recycle', buffer: ArrayBuffer}} Request
 * @typedef {{[K in keyof Listener]: {kind: K, args: Parameters<Listener[K]>}}[keyof Listener]} Event
 */

/** Time for the socket to say that it closes. */
const CLOSING_MS = 1000;

const now = () => performance.timeOrigin + performance.now();
/** @type {Connection | undefined} */
let connection;

/** @param {Event} event @param {Transferable[]} [transfer] */
const send = (event, transfer = []) => postMessage(event, { transfer });

/** @type {Listener} */
const on = {
  state: (...args) => send({ kind: 'state', args }),
  hello: (...args) => send({ kind: 'hello', args }),
  plan: (...args) => send({ kind: 'plan', args }),
  message: (...args) => send({ kind: 'message', args }),
  frame: (frame) => {
    const { buffer } = frame.counts ?? /** @type {Float32Array} */ (frame.floats);
    send({ kind: 'frame', args: [frame] }, [buffer]);
  },
  refused: (...args) => send({ kind: 'refused', args }),
  exchange: (...args) => send({ kind: 'exchange', args }),
  report: (...args) => send({ kind: 'report', args }),
};

onmessage = (/** @type {MessageEvent<Request>} */ { data }) => {
  switch (data.kind) {
    case 'open':
      connection = new Connection(data.url, data.wish, on, now);
      connection.open();
      break;
    case 'subscribe': connection?.subscribe(data.wish); break;
    case 'pause': connection?.pause(data.paused); break;
    case 'recycle': connection?.decoder.recycle(data.buffer); break;
    case 'close':
      connection?.close();
      setTimeout(() => close(), CLOSING_MS);
      break;
  }
};
