// A socket that is no socket, and what its server says first.

/** Stands in for WebSocket; all that were opened, the oldest first, are in `all`. */
export class FakeSocket {
  static OPEN = 1;

  static all = [];

  constructor(url, protocol) {
    Object.assign(this, { url, protocol, readyState: 1, sent: [], closed: false });
    FakeSocket.all.push(this);
  }

  send(text) {
    const message = JSON.parse(text);
    this.sent.push(message);
    // Where it says so: a server whose clock began at this Unix time, microseconds.
    const t = Math.round((performance.timeOrigin + performance.now()) * 1000) - this.began;
    if (message.type === 'time' && this.began !== undefined) this.say({ type: 'time', t0: message.t0, t1_us: t, t2_us: t });
  }

  close() { this.closed = true; }

  say(data) { this.onmessage({ data: typeof data === 'object' && !(data instanceof ArrayBuffer) ? JSON.stringify(data) : data }); }
}

/** Puts it in the place of WebSocket. */
export function useFakeSockets() {
  FakeSocket.all.length = 0;
  globalThis.WebSocket = FakeSocket;
}

export const EPOCH = 'ab54a98ceb1f0ad2'; // that of makeFrame
export const CASCADE = { index: 1, patch_m: 64, n: 8, levels: 2, wavelength_min_m: 1, wavelength_max_m: 9, from_tick: 0, until_tick: null };

/** A valid `hello` but for what `over` says. */
export const hello = (over = {}) => ({
  type: 'hello', protocol: 1, server: 's', scene: 'default', epoch: EPOCH, ticks_per_second: 7200, tick: 1, lead_ticks: 1680, sequence: 0,
  layout: { generation: 1, cascades: [CASCADE] }, rates_hz: [15, 30], classes: [{ name: '1mm' }],
  groups: ['displacement', 'slopes', 'derivatives', 'foam'].map((name) => ({ name, channels: [] })), limits: { units: 8 }, ...over,
});

