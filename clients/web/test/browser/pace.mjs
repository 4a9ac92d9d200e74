// What the sea costs a page that shows 90 pictures a second: decoding, and joining frames in time, by the GPU or not.
// For so many seconds, of a server with three cascades of 256 x 256; also pauses of the garbage collector, and memory.
// Twice: of the water's movement alone, which is decoded and sampled; and of all that the viewer shows.
//
//   node test/browser/pace.mjs --url http://127.0.0.1:8080/ [--seconds 60] [--rate 15] [--strict]
//
// Times are told; --strict makes those that are above what is promised a failure (for a machine that does nothing else).
// Pauses are told as the page sees them, and as what the collector itself worked: the difference is of the machine.
// By the GPU: what the page spends up to its calls. Here the processor plays the GPU, and takes half a second for what
// it is told; so it is told only a few times, each with the uploads of many frames: more than a page would pay.

import { readFileSync } from 'node:fs';
import { run } from './chromium.mjs';

const HZ = 90;
const MOST_MS = 3, MOST_PAUSE_MS = 5;
const GROWTH = 0.1; // of memory, from the second quarter to the last
const JOINED_BY_GPU = 10;

await run({ seconds: { type: 'string', default: '60' }, rate: { type: 'string', default: '15' }, strict: { type: 'boolean', default: false } }, async (test) => {
  const seconds = Number(test.args.seconds), rate = Number(test.args.rate), { strict } = test.args;
  const viewer = await test.viewer({ rate });
  const byGpuMs = await viewer.evaluate(joinByGpu, JOINED_BY_GPU);
  await viewer.close();

  console.log(JSON.stringify({ byGpuMs }));
  const checks = []; // at last: both are told
  for (const groups of [['displacement'], undefined]) {
    const page = await test.open({}, 'style.css'); // a page of the server with nothing on it
    await page.begin();
    await page.evaluate(async (rateHz, wanted) => {
      const { connect } = await import('/src/index.js');
      window.client = connect(location.origin, { rate: rateHz, groups: wanted });
    }, rate, groups);
    await test.until(page, () => window.client.playback && (window.client.sample(), window.client.playback.foamy));
    // Until everything is compiled, and a server that gave way at first sends all again.
    for (let round = 0; round < 6 && (await page.evaluate(join, 5, HZ)).levels.join() !== '0'; round++);
    const pid = await rendererPid(test.browser);
    await page.tracing.start({ categories: ['-*', 'devtools.timeline', 'v8'] });
    const memory = [], watch = setInterval(() => memory.push(rssMb(pid)), Math.max(250, seconds * 10));
    const told = await page.evaluate(join, seconds, HZ);
    clearInterval(watch);
    const pauses = pausesOf(JSON.parse(Buffer.from(await page.tracing.stop()).toString()));
    await page.close();
    const quarter = Math.floor(memory.length / 4), mean = (list) => list.reduce((a, b) => a + b, 0) / list.length;
    const before = mean(memory.slice(quarter, 2 * quarter)), after = mean(memory.slice(3 * quarter));
    const decodeMs = told.decodeMs * told.rate / HZ;
    const name = groups?.join() ?? 'all';
    console.log(JSON.stringify({ groups: name, picture: { decodeMs, sampleMs: told.sampleMs }, ...told, pauses, memoryMb: { before, after } }));
    checks.push([told.refused === 0, `${told.refused} frames refused`]);
    if (seconds >= 60) checks.push([after < before * (1 + GROWTH), `${name}: memory grows from ${before} to ${after} MB`]);
    if (!strict) continue;
    checks.push([told.joined > 0.9 * seconds * HZ, `${name}: ${told.joined} pictures in ${seconds} s`]);
    checks.push([decodeMs + told.sampleMs <= MOST_MS, `${name}: ${decodeMs} and ${told.sampleMs} ms a picture`]);
    checks.push([pauses.longestMs <= MOST_PAUSE_MS, `${name}: a pause of ${pauses.longestMs} ms`]);
  }
  for (const [holds, what] of checks) test.check(holds, what);
});

/** In the viewer: what going to a moment takes the page, a few times; each is awaited, so that none waits for another. */
async function joinByGpu(times) {
  const { client, renderer } = window.swellcast, { gl } = renderer.gpu, all = [];
  for (let i = 0; i < times; i++) {
    await new Promise((done) => setTimeout(done, 100));
    const began = performance.now();
    renderer.seek(client.tick(began), { windMps: null, windFromDeg: 0, hsM: 2 });
    all.push(performance.now() - began);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
  return all.sort((a, b) => a - b)[times >> 1];
}

/** In the page: samples displacement so many times a second, and times that. */
function join(seconds, hz) {
  const { client } = window, times = [], decode = [], levels = new Set();
  const begin = performance.now(), end = begin + seconds * 1000;
  let next = begin;
  return new Promise((done) => {
    const tick = () => {
      const now = performance.now();
      if (now >= next) {
        next = Math.max(next + 1000 / hz, now - 1000 / hz);
        client.sample(client.tick(now), ['displacement']);
        times.push(performance.now() - now);
        if (client.counts.decodeMs !== decode.at(-1)) decode.push(client.counts.decodeMs);
        client.playback.levels().forEach((level) => levels.add(level));
      }
      if (now < end) return setTimeout(tick, next - performance.now());
      times.sort((a, b) => a - b);
      done({ joined: times.length, sampleMs: times[times.length >> 1], sampleP95Ms: times[Math.floor(times.length * 0.95)],
        decodeMs: decode.sort((a, b) => a - b)[decode.length >> 1], rate: client.quality.rate_hz, levels: [...levels], refused: client.counts.refused });
    };
    tick();
  });
}

/** Pauses of V8's collector, of the page's threads: milliseconds that passed, and of those that were worked. */
function pausesOf({ traceEvents }) {
  const all = traceEvents.filter(({ ph, name, dur }) => ph === 'X' && dur && (name === 'MinorGC' || name === 'MajorGC'));
  const longest = (of) => Math.max(0, ...all.map((event) => (event[of] ?? event.dur) / 1000));
  const above = all.filter(({ dur }) => dur > MOST_PAUSE_MS * 1000).length;
  return { count: all.length, above, longestMs: longest('dur'), longestWorkMs: longest('tdur') };
}

/** The process that runs the page: the one of its kind that is busiest. */
async function rendererPid(browser) {
  const session = await browser.target().createCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  return processInfo.filter(({ type }) => type === 'renderer').sort((a, b) => b.cpuTime - a.cpuTime)[0].id;
}

function rssMb(pid) {
  return Number(readFileSync(`/proc/${pid}/statm`, 'utf8').split(' ')[1]) * 4096 / 1e6;
}
