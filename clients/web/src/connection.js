// One WebSocket to the server: connects, subscribes, exchanges time, decodes, reconnects.
// Runs in the worker; holds no time of its own beyond what a reconnect needs.

import { decodeFrame } from './decode.js';
import { FrameError } from './frame.js';
import { isThere, MessageError, parseServerMessage, subscribeMessage, SUBPROTOCOL, timeMessage } from './messages.js';
import { planUnits } from './plan.js';

const BACKOFF_MS = [250, 500, 1000, 2000, 4000];
const SILENCE_MS = 8000; // status comes once a second: longer silence is a dead connection
const FAST_EXCHANGES = 30;

export class Connection {
  /**
   * @param {string} url of the stream, ws: or wss:
   * @param {{rate: number, level: number, class: string}} wish what to subscribe to
   * @param {object} on callbacks: `state(connected, detail)`, `hello(hello, plan)`, `message(m)`,
   *   `frame(frame)`, `refused(why)`, `exchange(t0, t1, t2, t3)`
   * @param {() => number} now monotonic time, ms
   */
  constructor(url, wish, on, now) {
    Object.assign(this, { url, wish, on, now });
    this.attempt = 0;
    this.nextId = 1;
    this.paused = false;
    this.hello = null;
  }

  /** Connects, and stays connected. */
  open() {
    clearTimeout(this.retry);
    const socket = new WebSocket(this.url, SUBPROTOCOL);
    this.socket = socket;
    this.hello = null;
    this.lastHeard = this.now();
    socket.binaryType = 'arraybuffer';
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.lastHeard = this.now();
      if (typeof event.data === 'string') this.#text(event.data, this.lastHeard);
      else this.#binary(event.data);
    };
    socket.onclose = (event) => {
      if (socket === this.socket) this.#lost(event.reason || `closed with ${event.code}`);
    };
    clearInterval(this.watch);
    this.watch = setInterval(() => {
      if (this.now() - this.lastHeard > SILENCE_MS) this.restart('the server is silent');
    }, 1000);
  }

  /** Drops the socket and connects anew. */
  restart(why) {
    const old = this.socket;
    this.#lost(why);
    old?.close();
  }

  /** Stops or resumes the flow of frames, for a page that is hidden. */
  pause(paused) {
    if (this.paused === paused) return;
    this.paused = paused;
    if (this.hello) this.#subscribe();
  }

  #lost(why) {
    this.socket = null;
    this.hello = null;
    clearInterval(this.watch);
    clearTimeout(this.exchangeTimer);
    clearTimeout(this.retry);
    const base = BACKOFF_MS[Math.min(this.attempt++, BACKOFF_MS.length - 1)];
    this.retry = setTimeout(() => this.open(), base * (0.75 + 0.5 * Math.random()));
    this.on.state(false, why);
  }

  #text(json, at) {
    let message;
    try {
      message = parseServerMessage(json);
    } catch (error) {
      if (!(error instanceof MessageError)) throw error;
      this.on.refused(error.message);
      return;
    }
    if (!message) return;
    if (message.type === 'time') {
      this.on.exchange(message.t0, message.t1_us / 1000, message.t2_us / 1000, at);
    } else if (message.type === 'hello') {
      const further = this.hello?.epoch === message.epoch; // the layout changes: all else goes on
      this.hello = message;
      this.plan = planUnits(message, this.wish);
      this.cascades = new Map(message.layout.cascades.map((cascade) => [cascade.index, cascade]));
      this.on.hello(message, this.plan);
      this.on.state(true, '');
      this.#subscribe();
      if (further) return;
      this.exchanges = 0;
      this.#exchange();
    } else {
      this.on.message(message);
    }
  }

  #binary(buffer) {
    if (!this.hello) return;
    let frame;
    try {
      frame = decodeFrame(buffer);
    } catch (error) {
      if (!(error instanceof FrameError)) throw error;
      this.on.refused(error.message);
      return;
    }
    if (frame.epoch !== this.hello.epoch.toLowerCase()) {
      this.restart('another sea begins'); // its hello says which
      return;
    }
    this.attempt = 0; // it works
    const cascade = this.cascades.get(frame.cascade);
    if (cascade && isThere(cascade, frame.tick)) this.on.frame(frame);
  }

  #subscribe() {
    this.socket.send(subscribeMessage(this.nextId++, this.plan.rateHz, this.paused ? [] : this.plan.units));
  }

  #exchange() {
    clearTimeout(this.exchangeTimer);
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    this.socket.send(timeMessage(this.now()));
    const wait = this.exchanges++ < FAST_EXCHANGES ? 100 : 1000;
    this.exchangeTimer = setTimeout(() => this.#exchange(), wait);
  }
}
