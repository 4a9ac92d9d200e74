// What the sea costs a page of 90 pictures a second: decoding, and joining frames in time up to the calls to the GPU. The
// GPU itself is left out: here it is the processor that plays one, and would hold up a page that asks 90 times a second.
// So it is asked five times a second, and each time pays for the uploads of several frames: more than a page would.
// For so many seconds, of a server with three cascades of 256 x 256: cost, pauses of the garbage collector, memory.
//
//   node test/browser/pace.mjs --url http://127.0.0.1:8080/ [--seconds 60] [--rate 15] [--strict]
//
// Times are told; --strict makes those that are above what is promised a failure (for a machine that does nothing else).

import { readFileSync } from 'node:fs';
import { run } from './chromium.mjs';

const SHOWN_HZ = 90, ASKED_HZ = 5;
const MOST_MS = 3, MOST_PAUSE_MS = 5;
const GROWTH = 0.1; // of memory, from the second quarter to the last

await run({ seconds: { type: 'string', default: '60' }, rate: { type: 'string', default: '15' }, strict: { type: 'boolean', default: false } }, async (test) => {
  const seconds = Number(test.args.seconds), { strict } = test.args;
  const page = await test.viewer({ rate: test.args.rate });
  const pid = await rendererPid(test.browser);
  // Until everything is compiled and every buffer is there, and a server that gave way at first sends all again.
  for (let round = 0; round < 12; round++) {
    const { levels } = await page.evaluate(join, 5, ASKED_HZ);
    if (levels.join() === '0') break;
  }
  await page.tracing.start({ categories: ['-*', 'devtools.timeline', 'v8'] });
  const memory = [];
  const watch = setInterval(() => memory.push(rssMb(pid)), Math.max(250, seconds * 10));
  const told = await page.evaluate(join, seconds, ASKED_HZ);
  clearInterval(watch);
  const pauses = pausesOf(JSON.parse(Buffer.from(await page.tracing.stop()).toString()));
  const quarter = Math.floor(memory.length / 4), mean = (list) => list.reduce((a, b) => a + b, 0) / list.length;
  const before = mean(memory.slice(quarter, 2 * quarter)), after = mean(memory.slice(3 * quarter));
  const costMs = told.joinMs + told.decodeMs * told.rate / SHOWN_HZ;
  console.log(JSON.stringify({ costMs, ...told, pauses: pauses.length, longestPauseMs: Math.max(0, ...pauses), memoryMb: { before, after } }));
  test.check(told.joined > 0.9 * seconds * ASKED_HZ || !strict, `${told.joined} pictures in ${seconds} s`);
  if (seconds >= 60) test.check(after < before * (1 + GROWTH), `memory grows from ${before} to ${after} MB`);
  test.check(told.refused === 0, `${told.refused} frames refused`);
  if (!strict) return;
  test.check(costMs <= MOST_MS, `${costMs} ms a picture`);
  test.check(Math.max(0, ...pauses) <= MOST_PAUSE_MS, `a pause of ${Math.max(...pauses)} ms`);
});

/** In the page: joins the frames so many times a second, and times that. */
function join(seconds, hz) {
  const { client, renderer } = window.swellcast, times = [], decode = [], levels = new Set();
  const begin = performance.now(), end = begin + seconds * 1000;
  let next = begin;
  return new Promise((done) => {
    const tick = () => {
      const now = performance.now();
      if (now >= next) {
        next = Math.max(next + 1000 / hz, now - 1000 / hz);
        renderer.seek(client.tick(now), { windMps: null, windFromDeg: 0, hsM: 2 });
        times.push(performance.now() - now);
        if (client.counts.decodeMs !== decode.at(-1)) decode.push(client.counts.decodeMs);
        client.playback.levels().forEach((level) => levels.add(level));
      }
      // Timers are too coarse for the last milliseconds, and all of them would take a core from those that work.
      if (now < end && next - now > 5) return setTimeout(tick, 1);
      if (now < end) return channel.port2.postMessage(0);
      times.sort((a, b) => a - b);
      done({ joined: times.length, joinMs: times.reduce((a, b) => a + b, 0) / times.length, joinP95Ms: times[Math.floor(times.length * 0.95)], joinMostMs: times.at(-1),
        decodeMs: decode.sort((a, b) => a - b)[decode.length >> 1], rate: client.quality.rate_hz, levels: [...levels], refused: client.counts.refused });
    };
    const channel = new MessageChannel();
    channel.port1.onmessage = tick;
    tick();
  });
}

/** Milliseconds of each pause of V8's collector, of the page's threads. */
function pausesOf({ traceEvents }) {
  return traceEvents.filter(({ ph, name, dur }) => ph === 'X' && dur && (name === 'MinorGC' || name === 'MajorGC')).map(({ dur }) => dur / 1000);
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
