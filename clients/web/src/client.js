// A sea that is followed: the connection in a worker, and what this thread holds of it: clock, frames, messages.

import { Clock } from './clock.js';
import { Connection } from './connection.js';
import { GROUPS } from './frame.js';
import { TICKS_PER_SECOND } from './messages.js';
import { Playback } from './playback.js';

/**
 * @typedef {import('./connection.js').Hello} Hello
 * @typedef {import('./decode.js').DecodedFrame} DecodedFrame
 * @typedef {import('./messages.js').Message} Message
 * @typedef {import('./messages.js').Quality} Quality
 * @typedef {import('./messages.js').Subscribed} Subscribed
 * @typedef {import('./plan.js').Wish} Wish
 * @typedef {object} Events what `on` tells of
 * @property {{connected: boolean, detail: string}} state
 * @property {Hello} hello another sea, the same in another layout, or the same again after a loss
 * @property {Playback} playback `playback` is another from now on: of another sea, layout or subscription
 * @property {Message} message status, quality, change and all others that the server sends
 * @property {DecodedFrame} frame
 * @property {string} refused a frame or message that is wrong, and was dropped
 */

/** @type {Wish} */
const USUAL = { rate: 15, level: 0, class: '1mm', codec: 'rans' };

/**
 * Follows the sea of a server. Comes back by itself when the connection is lost, and asks for the same again.
 * @param {string | URL} url of the server, or of a stream of it: http:, https:, ws: or wss:
 * @param {Partial<Wish>} wish
 * @param {{worker?: boolean | Worker}} options `false`: decode in this thread; a worker of `@swellcast/client/worker`
 *   where a bundler doesn't find it by itself
 * @returns {Client}
 * @throws {TypeError} an address that is none, a group that is not known
 */
export function connect(url, wish = {}, { worker = typeof Worker !== 'undefined' } = {}) {
  return new Client(streamOf(url), known({ ...USUAL, ...wish }), worker);
}

/**
 * @param {Wish} wish
 * @returns {Wish}
 * @throws {TypeError}
 */
function known(wish) {
  const strange = wish.groups?.find((group) => !GROUPS.includes(group));
  if (strange !== undefined) throw new TypeError(`groups has ${strange}, must be of ${GROUPS.join(', ')}`);
  return wish;
}

export class Client {
  /** @type {Worker | null} */
  #worker = null;
  /** @type {Connection | null} */
  #connection = null;
  /** @type {Map<keyof Events, Set<(event: never) => void>>} each of what its kind tells */
  #handlers = new Map();
  #sea = ''; // epoch, layout and plan of what is held

  /**
   * @param {string} url of the stream
   * @param {Wish} wish
   * @param {boolean | Worker} worker
   */
  constructor(url, wish, worker) {
    this.url = url;
    this.wish = wish;
    this.connected = false;
    /** Server time of microseconds since this page began. */
    this.clock = new Clock();
    /** @type {Hello | null} */
    this.hello = null;
    /** @type {import('./messages.js').Status | null} the last one */
    this.status = null;
    /** @type {Subscribed | Quality | null} the last: what is granted, or what is sent where that differs */
    this.quality = null;
    /** @type {Playback | null} */
    this.playback = null;
    this.counts = { frames: 0, used: 0, refused: 0, bytes: 0, decodeMs: NaN, lastError: '' };
    if (worker) {
      this.#worker = worker === true ? new Worker(new URL('./worker.js', import.meta.url), { type: 'module' }) : worker;
      this.#worker.onmessage = ({ data }) => this.#hear(data);
      this.#worker.onerror = ({ message }) => this.#hear({ kind: 'state', args: [false, message || 'the worker does not start'] });
      this.#post({ kind: 'open', url, wish });
    } else {
      /** @type {import('./connection.js').Listener} */
      const on = {
        state: (...args) => this.#hear({ kind: 'state', args }),
        hello: (...args) => this.#hear({ kind: 'hello', args }),
        plan: (...args) => this.#hear({ kind: 'plan', args }),
        message: (...args) => this.#hear({ kind: 'message', args }),
        frame: (...args) => this.#hear({ kind: 'frame', args }),
        refused: (...args) => this.#hear({ kind: 'refused', args }),
        exchange: (...args) => this.#hear({ kind: 'exchange', args }),
        report: (...args) => this.#hear({ kind: 'report', args }),
      };
      this.#connection = new Connection(url, wish, on, () => performance.timeOrigin + performance.now());
      this.#connection.open();
    }
  }

  /**
   * @template {keyof Events} K
   * @param {K} kind
   * @param {(event: Events[K]) => void} handler
   * @returns {() => void} stops it
   */
  on(kind, handler) {
    const handlers = this.#handlers.get(kind) ?? new Set();
    this.#handlers.set(kind, handlers.add(handler));
    return () => handlers.delete(handler);
  }

  /**
   * Asks for something else: what is held is shown until that has come.
   * @param {Partial<Wish>} wish what is not named stays
   * @throws {TypeError} a group that is not known
   */
  subscribe(wish) {
    this.wish = known({ ...this.wish, ...wish });
    this.#connection?.subscribe(this.wish);
    this.#post({ kind: 'subscribe', wish: this.wish });
  }

  /**
   * Stops or resumes the flow of frames, for a page that is hidden.
   * @param {boolean} paused
   */
  pause(paused) {
    this.#connection?.pause(paused);
    this.#post({ kind: 'pause', paused });
  }

  /** Ends for good. */
  close() {
    this.#connection?.close();
    this.#post({ kind: 'close' });
    if (this.#worker) this.#worker.onmessage = null;
    this.#worker = null; // it ends by itself once the socket is closed
    this.connected = false;
    this.playback?.dispose();
  }

  /**
   * The tick that everybody shows at a moment.
   * @param {number} now `performance.now()`, or the time that a picture is drawn for
   * @returns {number} not a whole number in general; NaN before the first exchange of times
   */
  tick(now = performance.now()) {
    return this.clock.serverUs(now * 1000) * (TICKS_PER_SECOND / 1e6);
  }

  /** How far `tick` can be off, milliseconds. Infinity before the first exchange of times. */
  clockBoundMs(now = performance.now()) {
    return this.clock.errorBoundUs(now * 1000) / 1000;
  }

  /**
   * All that is held at a moment, or now.
   * @param {number} tick
   * @param {string[]} [groups]
   * @returns {import('./playback.js').Sampled[]} see `Playback.sample`
   */
  sample(tick = this.tick(), groups) {
    return Number.isFinite(tick) ? this.playback?.sample(tick, groups) ?? [] : [];
  }

  /**
   * The height of the water above a place of the world at a moment, or now: see `Playback.heightAt`. Frames reach about
   * a quarter of a second ahead.
   * @param {number} x metres to the east
   * @param {number} z metres to the south
   * @param {number} tick
   * @returns {number} metres above the rest surface; NaN where nothing is known yet
   */
  heightAt(x, z, tick = this.tick()) {
    if (!this.playback || !Number.isFinite(tick)) return NaN;
    if (this.playback.tick !== tick) this.playback.seek(tick);
    return this.playback.heightAt(x, z);
  }

  /** Gives memory of frames back to the decoder, unless somebody was given them. */
  #recycle() {
    if (!this.#worker || this.#handlers.has('frame')) return;
    for (const { counts } of this.playback?.spent ?? []) {
      if (!counts || counts.byteLength !== counts.buffer.byteLength) continue;
      const buffer = /** @type {ArrayBuffer} */ (counts.buffer);
      this.#worker.postMessage({ kind: 'recycle', buffer }, [buffer]);
    }
  }

  /** @param {import('./worker.js').Request} request */
  #post(request) {
    this.#worker?.postMessage(request);
  }

  /**
   * @template {keyof Events} K
   * @param {K} kind
   * @param {Events[K]} event
   */
  #tell(kind, event) {
    this.#handlers.get(kind)?.forEach((handler) => /** @type {(event: Events[K]) => void} */ (handler)(event));
  }

  /** @param {import('./worker.js').Event} event */
  #hear(event) {
    switch (event.kind) {
      case 'frame': {
        const [frame] = event.args;
        this.counts.frames++;
        this.counts.bytes += frame.bytes;
        if (this.playback?.accept(frame)) this.counts.used++;
        this.#recycle();
        this.#tell('frame', frame);
        break;
      }
      case 'exchange': {
        const own = (/** @type {number} */ us) => us - performance.timeOrigin * 1000;
        const [exchange] = event.args;
        this.clock.observe({ ...exchange, t0: own(exchange.t0), t3: own(exchange.t3) });
        break;
      }
      case 'report': this.counts.decodeMs = event.args[0].decode_ms; break;
      case 'refused':
        this.counts.refused++;
        this.counts.lastError = event.args[0];
        this.#tell('refused', event.args[0]);
        break;
      case 'state':
        this.connected = event.args[0];
        this.#tell('state', { connected: event.args[0], detail: event.args[1] });
        break;
      case 'hello': this.#begin(...event.args); break;
      case 'plan': if (this.hello) this.#hold(this.hello, ...event.args, true); break;
      case 'message': this.#message(event.args[0]); break;
    }
  }

  /** @param {Hello} hello @param {import('./plan.js').Plan} plan */
  #begin(hello, plan) {
    const goesOn = this.hello?.epoch === hello.epoch;
    if (!goesOn) this.clock.reset();
    this.hello = hello;
    this.#hold(hello, plan, goesOn);
    this.#tell('hello', hello);
  }

  /**
   * What is held from now on; what it is already stays true.
   * @param {Hello} hello
   * @param {import('./plan.js').Plan} plan
   * @param {boolean} goesOn the sea is the same
   */
  #hold(hello, plan, goesOn) {
    const sea = JSON.stringify([hello.epoch, hello.layout, plan]);
    if (sea === this.#sea) return;
    this.#sea = sea;
    if (!goesOn) this.playback?.dispose();
    this.playback = new Playback(hello.layout, plan, goesOn ? this.playback : null);
    this.#tell('playback', this.playback);
  }

  /** @param {Message} message */
  #message(message) {
    if (message.type === 'status') this.status = message;
    else if (message.type === 'subscribed' || message.type === 'quality') this.quality = message;
    this.#tell('message', message);
  }
}

/**
 * The stream of a server.
 * @param {string | URL} url
 * @returns {string}
 * @throws {TypeError} what is no address, or of another protocol
 */
export function streamOf(url) {
  const stream = new URL(url);
  if (!/^(https?|wss?):$/.test(stream.protocol)) throw new TypeError(`url is ${url}, must begin with http:, https:, ws: or wss:`);
  if (!stream.pathname.endsWith('/v1/stream')) stream.pathname = `${stream.pathname.replace(/\/$/, '')}/v1/stream`;
  stream.protocol = /^(https|wss):$/.test(stream.protocol) ? 'wss:' : 'ws:';
  stream.search = stream.hash = '';
  return stream.href;
}
