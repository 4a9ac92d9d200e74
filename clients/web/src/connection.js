// One WebSocket to the server: connects, subscribes, exchanges time, decodes, reports, reconnects.
// Runs in the worker; holds no time of its own beyond what a report and a reconnect need.

import { Clock } from './clock.js';
import { Decoder, MissingError, PayloadError } from './decode.js';
import { Fares } from './fares.js';
import { CLASSES, CODECS, FrameError, GROUPS } from './frame.js';
import { isThere, MessageError, parseServerMessage, reportMessage, subscribeMessage, SUBPROTOCOL, timeMessage } from './messages.js';
import { planUnits } from './plan.js';

const BACKOFF_MS = [250, 500, 1000, 2000, 4000];
const SILENCE_MS = 8000; // status comes once a second: longer silence is a dead connection
const FAST_EXCHANGES = 20;
const MOST_ASKED = 16; // exchanges whose answers are still awaited
const REPORT_MS = 1000;
/** Most samples of one moment that are kept for predictions: nine channels of three patches of 1024 x 1024 fit. */
const MOST_SAMPLES = 2 ** 25;

export class Connection {
  /**
   * @param {string} url of the stream, ws: or wss:
   * @param {{rate: number, level: number, class: string, codec: string}} wish what to subscribe to
   * @param {object} on callbacks: `state(connected, detail)`, `hello(hello, plan)`, `message(m)`, `frame(frame)`,
   *   `refused(why)`, `exchange(exchange)` in microseconds, `report(report)`
   * @param {() => number} now monotonic time, ms
   */
  constructor(url, wish, on, now) {
    Object.assign(this, { url, wish, on, now });
    this.attempt = 0;
    this.nextId = 1;
    this.paused = false;
    this.hello = null;
    this.clock = new Clock();
    this.fares = new Fares();
  }

  /** Connects, and stays connected. */
  open() {
    clearTimeout(this.retry);
    const socket = new WebSocket(this.url, SUBPROTOCOL);
    this.socket = socket;
    this.hello = null;
    this.decoder = new Decoder(MOST_SAMPLES);
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
    clearInterval(this.watch);
    this.watch = setInterval(() => {
      if (this.now() - this.lastHeard > SILENCE_MS) this.restart('the server is silent');
      else if (this.fares.newest > 0 && this.clock.synced) this.#report(false);
    }, REPORT_MS);
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
      this.asked = [];
      this.#exchange();
    } else {
      if (message.type === 'subscribed') this.#subscribed(message.units);
      this.on.message(message);
    }
  }

  #answered({ t0, t1_us: t1, t2_us: t2 }, at) {
    const place = this.asked?.indexOf(t0) ?? -1;
    if (place < 0) return;
    this.asked.splice(place, 1);
    const exchange = { t0, t1, t2, t3: microseconds(at) };
    this.clock.observe(exchange);
    this.on.exchange(exchange);
  }

  /** What was granted is all that goes on, and all of it at full quality. */
  #subscribed(units) {
    const names = new Set(units.map((u) => [u.cascade, u.level, u.class, u.group, u.codec ?? 'i16'].join()));
    this.decoder.retain((u) => names.has([u.cascade, u.level, CLASSES[u.class], GROUPS[u.group], CODECS[u.codec]].join()));
    this.fares.reset();
  }

  #binary(buffer) {
    if (!this.hello) return;
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
    if (frame.epoch !== this.hello.epoch.toLowerCase()) {
      this.restart('another sea begins'); // its hello says which
      return;
    }
    this.attempt = 0; // it works
    const cascade = this.cascades.get(frame.cascade);
    if (cascade && isThere(cascade, frame.tick)) this.on.frame(frame);
  }

  /** A frame that can't be read may leave others unread: all begins anew, unless that was asked for just now. */
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

  #report(lost) {
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    const report = this.fares.report(this.clock.serverUs(microseconds(this.now())));
    this.socket.send(reportMessage(report, lost));
    this.on.report(report);
  }

  #subscribe() {
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

function microseconds(ms) {
  return Math.round(ms * 1000);
}
