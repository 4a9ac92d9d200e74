// What decoding costs: p50 and p95 of the milliseconds that all frames of one tick take, and p95 over ticks of each
// one's median over rounds, which other work of the machine does not touch.
//
//   node test/decode-bench.mjs FOLDER|FILE... [--rounds 20] [--chromium [PATH]]
//
// A FOLDER holds files `*.frames` (each frame after its length, a u32, in sending order), or files of one frame each,
// `*.bin`, in the order of their names. With --chromium it runs in headless Chromium instead of Node. Frames of one
// tick stand together; ticks are told apart by their layer, and those of key frames by themselves.

import { createServer } from 'node:http';
import { existsSync, readdirSync, readFileSync, statSync } from 'node:fs';
import { basename, extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { measure } from './decode-measure.js';
import { split } from './streams.js';

const args = process.argv.slice(2);
const inChromium = args.includes('--chromium');
let chromium, rounds = 20;
const paths = [];
for (let i = 0; i < args.length; i++) {
  if (args[i] === '--rounds') rounds = Number(args[++i]);
  else if (args[i] !== '--chromium') paths.push(args[i]);
  else if (args[i + 1] && /chrom/.test(basename(args[i + 1])) && !statSync(args[i + 1]).isDirectory()) chromium = args[++i];
}
if (paths.length === 0) paths.push(fileURLToPath(new URL('../../../proto/vectors/streams', import.meta.url)));

const streams = paths.flatMap(streamsOf).filter(({ frames }) => frames.every((f) => new Uint8Array(f)[10] !== 2));
const results = inChromium ? await inBrowser() : streams.map(({ name, frames }) => ({ name, kinds: measure(frames, rounds) }));
console.log(inChromium ? `Chromium, ${rounds} rounds` : `Node ${process.version}, ${rounds} rounds`);
for (const { name, kinds } of results) {
  for (const { kind, ticks, samples, bytes, p50, p95, steady95 } of kinds) {
    console.log(`${name.padEnd(24)} ${kind.padEnd(22)} ${String(ticks).padStart(5)} ticks of ${(samples / 65536).toFixed(2)} x 256^2, `
      + `${(bytes / 1000).toFixed(1).padStart(6)} kB: p50 ${p50.toFixed(2)} ms, p95 ${p95.toFixed(2)} ms, undisturbed ${steady95.toFixed(2)} ms`);
  }
}

function streamsOf(path) {
  if (!statSync(path).isDirectory()) return [{ name: basename(path, extname(path)), frames: split(readFileSync(path)) }];
  const names = readdirSync(path).sort();
  const whole = names.filter((n) => n.endsWith('.frames')).flatMap((n) => streamsOf(join(path, n)));
  const single = names.filter((n) => n.endsWith('.bin')).map((n) => Uint8Array.from(readFileSync(join(path, n))).buffer);
  return single.length > 0 ? [...whole, { name: basename(path), frames: single }] : whole;
}

/** The same modules in a page of their own: a server hands them out, and the frames. */
async function inBrowser() {
  const { default: puppeteer } = await import('puppeteer-core');
  const executablePath = chromium ?? process.env.CHROMIUM
    ?? ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
  const root = fileURLToPath(new URL('..', import.meta.url));
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, 'http://localhost');
    const file = join(root, pathname);
    // A page that is alone with itself has a clock of 5 microseconds, not of 100.
    response.setHeader('cross-origin-opener-policy', 'same-origin').setHeader('cross-origin-embedder-policy', 'require-corp');
    if (pathname === '/') response.setHeader('content-type', 'text/html').end('<!doctype html>');
    else if (pathname.endsWith('.js') && existsSync(file)) response.setHeader('content-type', 'text/javascript').end(readFileSync(file));
    else if (/^\/stream\/\d+$/.test(pathname)) response.end(joined(streams[Number(pathname.slice(8))].frames));
    else response.writeHead(404).end();
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const browser = await puppeteer.launch({ executablePath, args: ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage'], protocolTimeout: 600_000 });
  try {
    const page = await browser.newPage();
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    const measured = [];
    for (let i = 0; i < streams.length; i++) {
      const kinds = await page.evaluate(async (index, count) => {
        const [{ measure: timed }, { split: parts }] = [await import('/test/decode-measure.js'), await import('/test/streams.js')];
        const bytes = await (await fetch(`/stream/${index}`)).arrayBuffer();
        return timed(parts(new Uint8Array(bytes)), count);
      }, i, rounds);
      measured.push({ name: streams[i].name, kinds });
    }
    return measured;
  } finally {
    await browser.close();
    server.close();
  }
}

function joined(frames) {
  return Buffer.concat(frames.flatMap((frame) => {
    const length = Buffer.alloc(4);
    length.writeUInt32LE(frame.byteLength);
    return [length, Buffer.from(frame)];
  }));
}
