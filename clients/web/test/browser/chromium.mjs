// What the browser tests share: Chromium on a software GPU, the viewer of a running server, and what went wrong.

import { existsSync } from 'node:fs';
import { parseArgs } from 'node:util';
import puppeteer from 'puppeteer-core';

const COMMON = {
  url: { type: 'string' },
  timeout: { type: 'string', default: '90' },
  chromium: { type: 'string' },
};

/**
 * Runs a test and ends the process: 0 when nothing was found wrong.
 * @param {object} options what the command line takes besides --url, --timeout and --chromium
 * @param {(test: Test) => Promise<void>} body
 */
export async function run(options, body) {
  const { values: args } = parseArgs({ options: { ...COMMON, ...options } });
  if (!args.url) fail('--url is missing: the address of a running server', 2);
  const chromium = args.chromium ?? process.env.CHROMIUM
    ?? ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
  if (!chromium) fail('no Chromium found: give --chromium PATH', 2);
  const browser = await puppeteer.launch({
    executablePath: chromium,
    args: ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--use-gl=angle', '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--hide-scrollbars', '--no-first-run',
      '--disable-background-networking', '--disable-component-update', '--disable-sync', '--disable-backgrounding-occluded-windows',
      '--disable-renderer-backgrounding', '--enable-precise-memory-info'],
    defaultViewport: { width: 1280, height: 720 },
    protocolTimeout: 180_000,
  });
  const test = new Test(browser, args);
  try {
    await body(test);
  } catch (error) {
    test.problems.push(error.stack);
  } finally {
    await browser.close();
  }
  if (test.problems.length > 0) fail(test.problems.join('\n'), 1);
  console.log('ok');
}

class Test {
  constructor(browser, args) {
    Object.assign(this, { browser, args, problems: [] });
  }

  check(holds, what) {
    if (!holds) this.problems.push(what);
  }

  /**
   * Opens a page of the server; whatever goes wrong in it is a problem.
   * @param {Record<string, string | undefined>} query
   * @param {string} path
   */
  async open(query = {}, path = '') {
    // A window of its own: a page behind another is hidden, and asks for no frames.
    const page = await (await this.browser.createBrowserContext()).newPage();
    page.on('console', (m) => {
      if (m.location().url?.endsWith('/favicon.ico')) return; // the browser's own wish
      if (m.type() === 'error' || /GL_INVALID|WebGL: INVALID/.test(m.text())) this.problems.push(`console: ${m.text()}`);
    });
    page.on('pageerror', (e) => this.problems.push(`page: ${e.message}`));
    page.on('requestfailed', (r) => this.problems.push(`request: ${r.url()} ${r.failure()?.errorText}`));
    const url = new URL(path, this.args.url);
    for (const [name, value] of Object.entries(query)) if (value !== undefined) url.searchParams.set(name, value);
    page.begin = () => page.goto(url.href, { waitUntil: 'load' });
    return page;
  }

  /** The viewer, once it has the sea, foam and all; it paints only when it is asked to from then on. */
  async viewer(query = {}, prepare = async () => {}) {
    const page = await this.open({ still: '1', adapt: '0', detail: 'low', ...query });
    await prepare(page);
    await page.begin();
    const state = await this.until(page, () => {
      const s = window.swellcast;
      if (s?.readyNow) s.held = true;
      return s?.readyNow && { ...s.client.counts, starved: s.starved, pictures: s.pictures, clockBoundMs: s.client.clockBoundMs() };
    });
    console.log(JSON.stringify(state));
    return page;
  }

  /** Waits until something holds in the page. */
  async until(page, holds) {
    const deadline = Date.now() + Number(this.args.timeout) * 1000;
    for (;;) {
      const value = await page.evaluate(holds);
      if (value) return value;
      if (this.problems.length > 0) throw new Error('the page failed');
      if (Date.now() > deadline) throw new Error(`not within ${this.args.timeout} s: ${holds}`);
      await new Promise((done) => setTimeout(done, 200));
    }
  }
}

/** Of pixels, RGBA: the mean of each colour. */
export function mean(rgba) {
  const sum = [0, 0, 0];
  rgba.forEach((v, i) => { if ((i & 3) < 3) sum[i & 3] += v; });
  return sum.map((v) => v / (rgba.length / 4));
}

/** Of pixels: how much green differs within them. */
export function deviation(rgba) {
  const green = rgba.filter((_, i) => (i & 3) === 1), middle = green.reduce((a, b) => a + b, 0) / green.length;
  return Math.sqrt(green.reduce((a, b) => a + (b - middle) ** 2, 0) / green.length);
}

/** Of two lists of pixels: the mean difference. */
export function difference(a, b) {
  return a.reduce((sum, v, i) => sum + Math.abs(v - b[i]), 0) / a.length;
}

function fail(what, status) {
  console.error(what);
  process.exit(status);
}
