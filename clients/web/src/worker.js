// The network's thread: the connection and the decoder live here, so that drawing never delays a
// time exchange and a burst of frames never delays drawing. Times are sent since the page epoch.

import { Connection } from './connection.js';

const now = () => performance.timeOrigin + performance.now();
let connection;

const on = {
  state: (connected, detail) => postMessage({ kind: 'state', connected, detail }),
  hello: (hello, plan) => postMessage({ kind: 'hello', hello, plan }),
  message: (message) => postMessage({ kind: 'message', message }),
  frame: (frame) => postMessage({ kind: 'frame', frame }, [frame.counts.buffer]),
  refused: (why) => postMessage({ kind: 'refused', why }),
  exchange: (exchange) => postMessage({ kind: 'exchange', exchange }),
  report: (report) => postMessage({ kind: 'report', report }),
};

onmessage = ({ data }) => {
  if (data.kind === 'open') {
    connection = new Connection(data.url, data.wish, on, now);
    connection.open();
  } else if (data.kind === 'pause') {
    connection?.pause(data.paused);
  }
};
