// One WebSocket to the server: connects, subscribes, exchanges time, decodes, reports, reconnects.
// Runs in the worker; holds no time of its own beyond what a report and a reconnect need.

import { Clock } from './clock.js';
import { Decoder } from './decode.js';
import { Fares } from './fares.js';
import { CLASSES, CODECS, epochOf, FrameError, GROUPS, MissingError, PayloadError } from './frame.js';
import {
  isThere, MessageError, parseServerMessage, reportMessage, subscribeMessage, SUBPROTOCOL, timeMessage,
} from './messages.js';
import { planUnits } from './plan.js';

const BACKOFF_MS = [250, 500, 1000, 2000, 3000];
const SILENCE_MS = 8000; // status comes once a second: longer silence is a dead connection
const FAST_EXCHANGES = 20;
const MOST_ASKED = 16; // exchanges whose answers are still awaited
const REPORT_MS = 1000;
/** Most samples of one moment that are kept for predictions: nine channels of three patches of 1024 x 1024 fit. */
const MOST_SAMPLES = 2 ** 25;

/**
 * @typedef {import('./decode.js').DecodedFrame} DecodedFrame
 * @typedef {import('./messages.js').Hello} Hello
 * @typedef {import('./plan.js').Wish} Wish
 * @typedef {import('./plan.js').Plan} Plan
 * @typedef {object} Listener
 * @property {(connected: boolean, detail: string) => void} state
 * @property {(hello: Hello, plan: Plan) => void} hello
 * @property {(plan: Plan) => void} plan something else is asked for, of the same sea
 * @property {(message: import('./messages.js').Message) => void} message
 * @property {(frame: DecodedFrame) => void} frame
 * @property {(why: string) => void} refused a frame or message that is wrong
 * @property {(exchange: import('./clock.js').Exchange) => void} exchange microseconds
 * @property {(report: import('./fares.js').Report) => void} report
 */

export class Connection {
  /**
   * @param {string} url of the stream, ws: or wss:
   * @param {Wish} wish what to subscribe to
   * @param {Listener} on
   * @param {() => number} now monotonic time, ms
   */
  constructor(url, wish, on, now) {
    this.url = url;
    this.wish = wish;
    this.on = on;
    this.now = now;
    this.attempt = 0;
    this.nextId = 1;
    this.paused = false;
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {Hello | null} of the socket */
    this.hello = null;
    this.epoch = ''; // of the last hello of all
    /** @type {Plan | null} what is asked for */
    this.plan = null;
    /** @type {Map<number, import('./messages.js').Cascade>} by index */
    this.cascades = new Map();
    this.clock = new Clock();
    this.fares = new Fares();
    this.decoder = new Decoder(MOST_SAMPLES);
    this.askedAnew = -Infinity; // when
    this.lastHeard = -Infinity;
    this.exchanges = 0; // of time, by this socket
    /** @type {number[]} when those exchanges began whose answers are awaited */
    this.asked = [];
    /** @type {number | undefined} timers: to connect anew, to look after the socket, to exchange time */
    this.retry = undefined;
    /** @type {number | undefined} */
    this.watch = undefined;
    /** @type {number | undefined} */
    this.exchangeTimer = undefined;
  }

  /** Connects, and stays connected. */
  open() {
    clearTimeout(this.retry);
    const socket = new WebSocket(this.url, SUBPROTOCOL);
    this.socket = socket;
    this.hello = null;
    this.decoder.retain(() => false);
    this.fares.reset();
    this.askedAnew = -Infinity;
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
    // `close` follows at once and says more, but in Node 20 it does not where nobody listens.
    socket.onerror = () => setTimeout(() => {
      if (socket === this.socket && socket.readyState !== WebSocket.OPEN) this.#lost('the connection failed');
    }, 0);
    clearInterval(this.watch);
    this.watch = setInterval(() => {
      if (this.now() - this.lastHeard > SILENCE_MS) this.restart('the server is silent');
      else if (this.fares.newest > 0 && this.clock.synced) this.#report(false);
    }, REPORT_MS);
  }

  /**
   * Drops the socket and connects anew.
   * @param {string} why
   */
  restart(why) {
    const old = this.socket;
    this.#lost(why);
    old?.close();
  }

  /**
   * Asks for something else.
   * @param {Wish} wish
   */
  subscribe(wish) {
    this.wish = wish;
    if (!this.hello) return;
    this.plan = planUnits(this.hello, wish);
    this.on.plan(this.plan);
    this.#subscribe();
  }

  /** Ends for good. */
  close() {
    const old = this.socket;
    this.socket = null;
    this.#stop();
    this.decoder.retain(() => false);
    old?.close(1000);
  }

  /**
   * Stops or resumes the flow of frames, for a page that is hidden.
   * @param {boolean} paused
   */
  pause(paused) {
    if (this.paused === paused) return;
    this.paused = paused;
    if (this.hello) this.#subscribe();
  }

  /** @param {string} why */
  #lost(why) {
    this.socket = null;
    this.#stop();
    const base = BACKOFF_MS[Math.min(this.attempt++, BACKOFF_MS.length - 1)];
    this.retry = setTimeout(() => this.open(), base * (0.75 + 0.5 * Math.random()));
    this.on.state(false, why);
  }

  #stop() {
    this.hello = null;
    clearInterval(this.watch);
    clearTimeout(this.exchangeTimer);
    clearTimeout(this.retry);
  }

  /** @param {string} json @param {number} at ms */
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
      this.#answered(message, at);
    } else if (message.type === 'hello') {
      const further = this.hello?.epoch === message.epoch; // the layout changes: all else goes on
      if (!further && this.epoch !== message.epoch) this.clock.reset();
      this.epoch = message.epoch;
      this.hello = message;
      this.plan = planUnits(message, this.wish);
      this.cascades = new Map(message.layout.cascades.map((cascade) => [cascade.index, cascade]));
      this.on.hello(message, this.plan);
      this.on.state(true, '');
      this.#subscribe();
      if (further) return;
      this.exchanges = 0;
      this.asked.length = 0;
      this.#exchange();
    } else {
      if (message.type === 'subscribed') this.#subscribed(message.units);
      this.on.message(message);
    }
  }

  /** @param {import('./messages.js').Time} answer @param {number} at ms */
  #answered({ t0, t1_us: t1, t2_us: t2 }, at) {
    const place = this.asked.indexOf(t0);
    if (place < 0) return;
    this.asked.splice(place, 1);
    const exchange = { t0, t1, t2, t3: microseconds(at) };
    this.clock.observe(exchange);
    this.on.exchange(exchange);
  }

  /**
   * What was granted is all that goes on, and all of it at full quality.
   * @param {import('./messages.js').UnitName[]} units
   */
  #subscribed(units) {
    const names = new Set(units.map((u) => [u.cascade, u.level, u.class, u.group, u.codec ?? 'i16'].join()));
    this.decoder.retain((u) => names.has([u.cascade, u.level, CLASSES[u.class], GROUPS[u.group], CODECS[u.codec]].join()));
    this.fares.reset();
  }

  /** @param {ArrayBuffer} buffer */
  #binary(buffer) {
    if (!this.hello) return;
    const epoch = epochOf(buffer);
    if (epoch !== null && epoch !== this.hello.epoch.toLowerCase()) return; // of another sea
    const began = this.now();
    let frame;
    try {
      frame = this.decoder.decode(buffer);
    } catch (error) {
      if (!(error instanceof FrameError)) throw error;
      this.#refused(error);
      return;
    }
    this.fares.decoded(frame.tick, this.now() - began);
    this.attempt = 0; // it works
    const cascade = this.cascades.get(frame.cascade);
    if (cascade && isThere(cascade, frame.tick)) this.on.frame(frame);
  }

  /**
   * A frame that can't be read may leave others unread: all begins anew, unless that was asked for just now.
   * @param {FrameError} error
   */
  #refused(error) {
    const begins = error instanceof MissingError || error instanceof PayloadError;
    const waits = this.now() - this.askedAnew < REPORT_MS;
    if (begins && !waits) {
      this.askedAnew = this.now();
      this.#report(true);
    }
    // What was under way when a new beginning was asked for is no fault.
    if (!(error instanceof MissingError && waits)) this.on.refused(error.message);
  }

  /** @param {boolean} lost */
  #report(lost) {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const report = this.fares.report(this.clock.serverUs(microseconds(this.now())));
    this.socket.send(reportMessage(report, lost));
    this.on.report(report);
  }

  #subscribe() {
    if (!this.socket || !this.plan) return; // who was told of `hello` has closed it
    this.socket.send(subscribeMessage(this.nextId++, this.plan.rateHz, this.paused ? [] : this.plan.units));
  }

  #exchange() {
    clearTimeout(this.exchangeTimer);
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const t0 = microseconds(this.now());
    if (this.asked.length === MOST_ASKED) this.asked.shift();
    this.asked.push(t0);
    this.socket.send(timeMessage(t0));
    const wait = this.exchanges++ < FAST_EXCHANGES ? 100 : 1000;
    this.exchangeTimer = setTimeout(() => this.#exchange(), wait);
  }
}

/** @param {number} ms */
function microseconds(ms) {
  return Math.round(ms * 1000);
}
