// Opens the viewer of a running server in headless Chromium, waits for the sea, looks at it.
//
//   node test/browser.mjs --url http://127.0.0.1:8080/ --out sea.png [--eye x,y,z] [--look yaw,pitch]
//                         [--rate 15] [--query more=1] [--timeout 60] [--chromium PATH] [--panel]

import { existsSync, writeFileSync } from 'node:fs';
import { parseArgs } from 'node:util';
import puppeteer from 'puppeteer-core';

const { values: args } = parseArgs({
  options: {
    url: { type: 'string' },
    out: { type: 'string', default: 'sea.png' },
    eye: { type: 'string' },
    look: { type: 'string' },
    rate: { type: 'string' },
    detail: { type: 'string', default: 'low' },
    query: { type: 'string' },
    timeout: { type: 'string', default: '60' },
    chromium: { type: 'string' },
    panel: { type: 'boolean', default: false },
  },
});
if (!args.url) fail('--url is missing: the address of a running server', 2);

const chromium = args.chromium ?? process.env.CHROMIUM
  ?? ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
if (!chromium) fail('no Chromium found: give --chromium PATH', 2);

const url = new URL(args.url);
for (const name of ['eye', 'look', 'rate', 'detail']) if (args[name]) url.searchParams.set(name, args[name]);
if (!args.panel) url.searchParams.set('still', '1');
for (const [name, value] of new URLSearchParams(args.query ?? '')) url.searchParams.set(name, value);

const browser = await puppeteer.launch({
  executablePath: chromium,
  args: ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--hide-scrollbars'],
  defaultViewport: { width: 1280, height: 720 },
  protocolTimeout: 180_000,
});
const problems = [];
try {
  await look();
} catch (error) {
  problems.push(error.message);
} finally {
  await browser.close();
}
if (problems.length > 0) fail(problems.join('\n'), 1);
console.log(`ok: ${args.out}`);

async function look() {
  const page = await browser.newPage();
  page.on('console', (m) => {
    if (m.type() === 'error' || /GL_INVALID|WebGL: INVALID/.test(m.text())) problems.push(`console: ${m.text()}`);
  });
  page.on('pageerror', (e) => problems.push(`page: ${e.message}`));
  page.on('requestfailed', (r) => problems.push(`request: ${r.url()} ${r.failure()?.errorText}`));
  await page.goto(url.href, { waitUntil: 'load' });

  const deadline = Date.now() + Number(args.timeout) * 1000;
  for (;;) {
    const state = await page.evaluate(() => {
      const s = window.swellcast;
      if (s?.readyNow) s.held = true;
      return s && { ready: s.readyNow, connected: s.connected, framesDecoded: s.framesDecoded, framesUsed: s.framesUsed,
        decodeErrors: s.decodeErrors, lastError: s.lastError, starved: s.starved, pictures: s.pictures,
        clockBoundMs: s.clockBoundMs };
    });
    if (problems.length > 0) return;
    if (state?.ready) {
      console.log(JSON.stringify(state));
      break;
    }
    if (Date.now() > deadline) throw new Error(`not ready after ${args.timeout} s: ${JSON.stringify(state)}`);
    await new Promise((done) => setTimeout(done, 200));
  }

  const first = await picture(page);
  if (args.panel) await page.screenshot({ path: args.out });
  else writeFileSync(args.out, Buffer.from(first.png.split(',')[1], 'base64'));
  await page.evaluate(() => new Promise((done) => setTimeout(done, 600)));
  const second = await picture(page);
  const state = await page.evaluate(() => {
    const { connected, framesDecoded, decodeErrors, lastError } = window.swellcast;
    return { connected, framesDecoded, decodeErrors, lastError };
  });

  check(state.connected, 'not connected');
  check(state.framesDecoded > 0, 'no frame decoded');
  check(state.decodeErrors === 0, `${state.decodeErrors} decode errors, last: ${state.lastError}`);
  const moved = difference(first.sea, second.sea);
  const sky = mean(first.sky), sea = mean(first.sea);
  const apart = Math.hypot(sky[0] - sea[0], sky[1] - sea[1], sky[2] - sea[2]);
  const contrast = deviation(first.sea);
  console.log(JSON.stringify({ apart, contrast, moved }));
  if (first.hasSky) check(apart > 12, `sky and sea look alike: ${apart}`);
  check(contrast > 3, `the sea is flat: deviation ${contrast}`);
  check(moved > 0.5, `the sea stands still: mean difference ${moved}`);
}

/** Has one picture painted; pixels of a strip of sky (top) and of sea (bottom) are read in the task that drew them. */
async function picture(page) {
  return page.evaluate(() => {
    window.swellcast.held = true; // a software GPU would else be busy with pictures nobody looks at
    window.swellcast.paint(performance.now());
    const canvas = document.getElementById('sea');
    const gl = canvas.getContext('webgl2');
    const w = canvas.width, h = Math.floor(canvas.height / 8);
    const read = (y) => {
      const out = new Uint8Array(w * h * 4);
      gl.readPixels(0, y, w, h, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return Array.from(out.filter((_, i) => (i >> 2) % 7 === 0));
    };
    return { png: canvas.toDataURL('image/png'), sky: read(canvas.height - h), sea: read(h),
      hasSky: window.swellcast.camera.pitch > -15 };
  });
}

function mean(rgba) {
  const sum = [0, 0, 0];
  rgba.forEach((v, i) => { if ((i & 3) < 3) sum[i & 3] += v; });
  return sum.map((v) => v / (rgba.length / 4));
}

function deviation(rgba) {
  const green = rgba.filter((_, i) => (i & 3) === 1);
  const middle = green.reduce((a, b) => a + b, 0) / green.length;
  return Math.sqrt(green.reduce((a, b) => a + (b - middle) ** 2, 0) / green.length);
}

function difference(a, b) {
  return a.reduce((sum, v, i) => sum + Math.abs(v - b[i]), 0) / a.length;
}

function check(holds, what) {
  if (!holds) problems.push(what);
}

function fail(what, status) {
  console.error(what);
  process.exit(status);
}
