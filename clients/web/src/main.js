// The page: joins network, clock, sea, camera and panel. Everything happens once a picture.

import { Camera } from './camera.js';
import { Clock } from './clock.js';
import { TICKS_PER_SECOND } from './messages.js';
import { readOptions } from './options.js';
import { Panel } from './panel.js';
import { waterHeight } from './sea/probe.js';
import { Renderer } from './sea/renderer.js';

const FOAM_PATIENCE_MS = 20_000; // foam may take long to be warm: the sea is ready without it
const PANEL_MS = 250;

const options = readOptions(location.search);
const canvas = document.getElementById('sea');
const camera = new Camera(options.eye, options.look);
const clock = new Clock(); // microseconds since this page began
const panel = new Panel(document);
const weather = { windMps: null, windFromDeg: 0, hsM: 2 };

/** For tests and the curious. */
const swellcast = {
  connected: false,
  framesDecoded: 0,
  framesUsed: 0,
  decodeErrors: 0,
  lastError: '',
  bytes: 0,
  decodeMs: NaN,
  quality: null, // `subscribed`, or the `quality` that what comes differs from it by
  tick: NaN,
  clockBoundMs: Infinity,
  starved: 0,
  pictures: 0,
  readyNow: false,
  ready: null,
  hello: null,
  status: null,
  camera,
  held: false, // no pictures but those asked for by `paint(performance.now())`
  paint,
};
swellcast.ready = new Promise((resolve) => {
  swellcast.setReady = () => {
    swellcast.readyNow = true;
    resolve(true);
  };
});
window.swellcast = swellcast;

let renderer;
try {
  renderer = new Renderer(canvas, options);
} catch (error) {
  notice(`The sea can't be drawn: ${error.message}.`);
  throw error;
}
swellcast.renderer = renderer;
canvas.addEventListener('webglcontextlost', (event) => {
  event.preventDefault();
  location.reload();
});

camera.attach(canvas);
if (!options.still) panel.show();

const worker = new Worker(new URL('worker.js', import.meta.url), { type: 'module' });
const stream = new URL('v1/stream', location.href);
stream.protocol = stream.protocol === 'https:' ? 'wss:' : 'ws:';
stream.search = '';
worker.postMessage({ kind: 'open', url: stream.href, wish: { rate: options.rate, level: options.level, class: options.class, codec: options.codec } });
document.addEventListener('visibilitychange', () => worker.postMessage({ kind: 'pause', paused: document.hidden }));

let sea = ''; // epoch, layout and plan of what is held
worker.onmessage = ({ data }) => {
  const own = (us) => us - performance.timeOrigin * 1000;
  switch (data.kind) {
    case 'frame':
      swellcast.framesDecoded++;
      swellcast.bytes += data.frame.bytes;
      if (renderer.fields?.accept(data.frame)) swellcast.framesUsed++;
      break;
    case 'exchange': clock.observe({ ...data.exchange, t0: own(data.exchange.t0), t3: own(data.exchange.t3) }); break;
    case 'report': swellcast.decodeMs = data.report.decode_ms; break;
    case 'refused':
      swellcast.decodeErrors++;
      swellcast.lastError = data.why;
      break;
    case 'state':
      swellcast.connected = data.connected;
      panel.setState(data.connected, data.detail);
      break;
    case 'hello': begin(data.hello, data.plan); break;
    case 'message': hear(data.message); break;
    default: break;
  }
};

function begin(hello, plan) {
  const goesOn = swellcast.hello?.epoch === hello.epoch;
  if (!goesOn) clock.reset();
  swellcast.hello = hello;
  panel.setHello(hello);
  const next = JSON.stringify([hello.epoch, hello.layout, plan]);
  if (next === sea) return; // the same sea again: what is held stays true
  sea = next;
  renderer.setSea(hello.layout, plan, goesOn);
}

function hear(message) {
  if (message.type === 'status') {
    swellcast.status = message;
    weather.windMps = message.wind ? message.wind.speed_mps : null;
    weather.windFromDeg = message.wind?.direction_from_deg ?? 0;
    weather.hsM = message.hs_m;
    panel.setStatus(message);
  } else if (message.type === 'subscribed' || message.type === 'quality') {
    swellcast.quality = message; // a subscription is granted in full at first
  } else if (message.type === 'change') {
    panel.setChange(message);
  } else if (message.type === 'error') {
    notice(`The server refuses: ${message.detail}`);
  }
}

function notice(text) {
  const box = document.getElementById('notice');
  box.textContent = text;
  box.hidden = false;
}

let last = performance.now();
let completeAt = NaN;
const seen = { at: last, pictures: 0, bytes: 0 };

function picture(now) {
  requestAnimationFrame(picture);
  if (!swellcast.held) paint(now);
}

function paint(now) {
  const tick = clock.serverUs(now * 1000) * (TICKS_PER_SECOND / 1e6);
  const { fields } = renderer;
  camera.move((now - last) / 1000, fields?.complete ? waterHeight(fields, camera.eye[0], camera.eye[2]) : -Infinity);
  last = now;
  const { drawn, starved } = renderer.draw(tick, camera, weather);
  swellcast.tick = tick;
  if (drawn) {
    swellcast.pictures++;
    if (starved) swellcast.starved++;
    if (!swellcast.readyNow) {
      if (Number.isNaN(completeAt)) completeAt = now;
      if (fields.foamy || now - completeAt > FOAM_PATIENCE_MS) swellcast.setReady();
    }
  }
  if (now - seen.at > PANEL_MS) report(now);
}

function report(now) {
  const seconds = (now - seen.at) / 1000;
  swellcast.clockBoundMs = clock.errorBoundUs(now * 1000) / 1000;
  panel.setNumbers({
    tick: swellcast.tick,
    boundMs: swellcast.clockBoundMs,
    aheadTicks: renderer.fields?.ahead(swellcast.tick) ?? 0,
    bytesPerSecond: (swellcast.bytes - seen.bytes) / seconds,
    decodeMs: swellcast.decodeMs,
    rateHz: swellcast.quality?.rate_hz ?? 0,
    levels: renderer.fields?.levels() ?? [],
    fps: (swellcast.pictures - seen.pictures) / seconds,
    starved: swellcast.starved,
    refused: swellcast.decodeErrors,
  });
  Object.assign(seen, { at: now, pictures: swellcast.pictures, bytes: swellcast.bytes });
}

requestAnimationFrame(picture);
