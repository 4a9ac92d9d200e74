// The page: joins the client, camera, renderer, panel and headset. Everything happens once a picture.

import { connect } from '../src/index.js';
import { Camera } from './camera.js';
import { Deck } from './deck.js';
import { GpuTime } from './gputime.js';
import { readOptions } from './options.js';
import { Pace } from './pace.js';
import { Panel } from './panel.js';
import { Quality, stepsOf } from './quality.js';
import { Renderer } from './renderer.js';
import { Solids } from './solids.js';
import { View } from './view.js';
import { canEnter, Immersion } from './xr.js';

const FOAM_PATIENCE_MS = 20_000; // foam may take long to be warm: the sea is ready without it
const PANEL_MS = 250;

const options = readOptions(location.search);
const canvas = document.getElementById('sea');
const camera = new Camera(options.eye, options.look);
const panel = new Panel(document);
const pace = new Pace();
const weather = { windMps: null, windFromDeg: 0, hsM: 2 };
const wish = { rate: options.rate, level: options.level, class: options.class, codec: options.codec === 'i16' ? 'i16' : 'rans' };
const client = connect(new URL('.', location.href), wish);

/** For tests and the curious. */
const swellcast = {
  client,
  camera,
  pace,
  tick: NaN,
  starved: 0,
  pictures: 0,
  readyNow: false,
  immersion: null,
  held: false, // no pictures but those asked for by `paint(performance.now())`
  paint,
};
window.swellcast = swellcast;

let renderer;
try {
  renderer = new Renderer(canvas, options);
} catch (error) {
  notice(`The sea can't be drawn: ${error.message}.`);
  throw error;
}
canvas.addEventListener('webglcontextlost', (event) => {
  event.preventDefault();
  location.reload();
});
const { gl } = renderer.gpu;
const gpuTime = new GpuTime(gl), screen = new View(), deck = new Deck(), solids = new Solids(gl);
swellcast.renderer = renderer;

camera.attach(canvas);
if (!options.still) panel.show();
let last = NaN; // when the picture before was

/** No frames for a page that nobody sees; and what passes meanwhile is no measure of anything. */
function rest() {
  client.pause(document.hidden && !swellcast.immersion);
  last = NaN;
}
document.addEventListener('visibilitychange', rest);

let quality = null;
client.on('hello', (hello) => {
  panel.setHello(hello);
  const levels = Math.min(...hello.layout.cascades.map((cascade) => cascade.levels));
  if (options.adapt && !quality) quality = new Quality(stepsOf(wish, levels));
});
client.on('playback', (playback) => renderer.setSea(playback));
client.on('state', ({ connected, detail }) => panel.setState(connected, detail));
client.on('message', (message) => {
  if (message.type === 'status') {
    weather.windMps = message.wind ? message.wind.speed_mps : null;
    weather.windFromDeg = message.wind?.direction_from_deg ?? 0;
    weather.hsM = message.hs_m;
    panel.setStatus(message);
  } else if (message.type === 'change') {
    panel.setChange(message);
  } else if (message.type === 'error') {
    notice(`The server refuses: ${message.detail}`);
  }
});

function notice(text) {
  const box = document.getElementById('notice');
  box.textContent = text;
  box.hidden = false;
}

/** The height of the water; -Infinity before there is any. */
function water(x, z) {
  return client.playback?.complete ? client.playback.heightAt(x, z) : -Infinity;
}

let completeAt = NaN;
const seen = { at: performance.now(), bytes: 0 };

let asked = 0; // the picture that is asked for
function picture(now) {
  if (swellcast.immersion) return;
  asked = rest();
asked = requestAnimationFrame(picture);
  if (!swellcast.held) paint(now);
}

/** One picture, of the moment `now`, on the screen or in the headset whose frame is given. */
function paint(now, frame = null) {
  const { immersion } = swellcast, began = performance.now();
  const intervalMs = now - last, seconds = Math.max(0, intervalMs / 1000) || 0;
  last = now;
  gpuTime.begin();
  const tick = client.tick(now);
  const { drawn, starved } = renderer.seek(tick, weather);
  if (frame && immersion) wear(immersion, frame, seconds);
  else show(seconds);
  gpuTime.end();
  swellcast.tick = tick;
  if (drawn) ready(now, starved);
  const costMs = Math.max(performance.now() - began, gpuTime.ms);
  if (Number.isFinite(intervalMs)) judge(intervalMs, costMs, drawn);
  if (now - seen.at > PANEL_MS) report(now);
}

function judge(intervalMs, costMs, drawn) {
  pace.picture(intervalMs, costMs, swellcast.immersion?.session.frameRate);
  const step = drawn ? quality?.picture(intervalMs, costMs, pace.targetMs, gpuTime.known) : null;
  if (!step) return;
  client.subscribe({ rate: step.rate, level: step.level });
  renderer.setMesh(step.coarse || options.detail === 'low');
}

function show(seconds) {
  renderer.fit();
  camera.move(seconds, water(camera.eye[0], camera.eye[2]));
  screen.viewport = [0, 0, canvas.width, canvas.height];
  screen.look(camera.eye, camera.axes(), camera.tangents(canvas.width / canvas.height));
  renderer.paint([screen], null);
}

function wear(immersion, frame, seconds) {
  if (client.playback?.complete) deck.float(water);
  const views = immersion.look(frame, seconds, water), mark = immersion.markMatrix(water);
  const things = [{ mesh: solids.boat, model: deck.matrix() }, { mesh: solids.board, model: immersion.boardMatrix() }];
  if (mark) things.push({ mesh: solids.mark, model: mark });
  const { framebuffer } = immersion.session.renderState.baseLayer;
  renderer.paint(views, framebuffer, (view) => solids.draw(view, renderer.sun, things));
}

function ready(now, starved) {
  swellcast.pictures++;
  if (starved) swellcast.starved++;
  if (swellcast.readyNow) return;
  if (Number.isNaN(completeAt)) completeAt = now;
  swellcast.readyNow = client.playback.foamy || now - completeAt > FOAM_PATIENCE_MS;
}

function report(now) {
  const seconds = (now - seen.at) / 1000, { counts, playback } = client;
  const numbers = {
    tick: swellcast.tick,
    boundMs: client.clockBoundMs(now),
    aheadTicks: playback?.ahead(swellcast.tick) ?? 0,
    bytesPerSecond: (counts.bytes - seen.bytes) / seconds,
    decodeMs: counts.decodeMs,
    rateHz: client.quality?.rate_hz ?? 0,
    levels: playback?.levels() ?? [],
    fps: pace.pictures / seconds,
    pictureMs: pace.costMs / Math.max(1, pace.pictures),
    dropped: pace.dropped,
    starved: swellcast.starved,
    refused: counts.refused,
  };
  panel.setNumbers(numbers);
  if (swellcast.immersion) solids.write(panel.lines(numbers));
  Object.assign(seen, { at: now, bytes: counts.bytes });
  pace.reset();
}

/** Enters VR, on the deck of a boat or in the water. */
async function enter() {
  const immersion = await Immersion.enter(gl, deck, { eye: camera.eye, yaw: camera.yaw }, panel.floor());
  swellcast.immersion = immersion;
  const { session } = immersion;
  const loop = (now, frame) => {
    session.requestAnimationFrame(loop);
    if (!swellcast.held) paint(now, frame);
  };
  session.addEventListener('end', () => {
    swellcast.immersion = null;
    panel.setImmersed(false);
    pace.begin();
    rest();
    cancelAnimationFrame(asked); // a browser may have kept it for the page's return
    asked = requestAnimationFrame(picture);
  });
  panel.setImmersed(true);
  rest();
  solids.write(['Swellcast', 'trigger: go there', 'grip: deck or sea']);
  session.requestAnimationFrame(loop);
}

canEnter().then((can) => {
  if (can) panel.offerVr(() => (swellcast.immersion ? swellcast.immersion.session.end() : enter()).catch((error) => notice(`VR: ${error.message}`)));
});
requestAnimationFrame(picture);
