// Opens the viewer of a running server in headless Chromium, waits for the sea, looks at it.
//
//   node test/browser/look.mjs --url http://127.0.0.1:8080/ --out sea.png [--eye x,y,z] [--look yaw,pitch] [--sun a,e]
//                              [--rate 15] [--detail high] [--panel] [--timeout 90] [--chromium PATH]

import { writeFileSync } from 'node:fs';
import { deviation, difference, mean, run } from './chromium.mjs';

const options = {
  out: { type: 'string', default: 'sea.png' },
  eye: { type: 'string' },
  look: { type: 'string' },
  sun: { type: 'string' },
  rate: { type: 'string' },
  detail: { type: 'string', default: 'low' },
  panel: { type: 'boolean', default: false },
};

await run(options, async (test) => {
  const { out, panel, eye, look, sun, rate, detail } = test.args;
  const page = await test.viewer({ eye, look, sun, rate, detail, still: panel ? undefined : '1' });
  const type = out.endsWith('.jpg') ? 'image/jpeg' : 'image/png';
  const first = await picture(page, type);
  if (panel) await page.screenshot({ path: out });
  else writeFileSync(out, Buffer.from(first.image.split(',')[1], 'base64'));
  await page.evaluate(() => new Promise((done) => setTimeout(done, 600)));
  const second = await picture(page, type);
  const { connected, counts } = await page.evaluate(() => ({ connected: window.swellcast.client.connected, counts: window.swellcast.client.counts }));
  test.check(connected, 'not connected');
  test.check(counts.frames > 0, 'no frame decoded');
  test.check(counts.refused === 0, `${counts.refused} frames refused, last: ${counts.lastError}`);
  const moved = difference(first.sea, second.sea);
  const sky = mean(first.sky), sea = mean(first.sea);
  const apart = Math.hypot(sky[0] - sea[0], sky[1] - sea[1], sky[2] - sea[2]);
  const contrast = deviation(first.sea);
  console.log(JSON.stringify({ out, apart, contrast, moved }));
  if (first.hasSky) test.check(apart > 12, `sky and sea look alike: ${apart}`);
  test.check(contrast > 3, `the sea is flat: deviation ${contrast}`);
  test.check(moved > 0.5, `the sea stands still: mean difference ${moved}`);
});

/** Has one picture painted; pixels of a strip of sky (top) and of sea (bottom) are read in the task that drew them. */
async function picture(page, type) {
  return page.evaluate((wanted) => {
    window.swellcast.paint(performance.now());
    const canvas = document.getElementById('sea');
    const gl = canvas.getContext('webgl2');
    const w = canvas.width, h = Math.floor(canvas.height / 8);
    const read = (y) => {
      const out = new Uint8Array(w * h * 4);
      gl.readPixels(0, y, w, h, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return Array.from(out.filter((_, i) => (i >> 2) % 7 === 0));
    };
    return { image: canvas.toDataURL(wanted, 0.9), sky: read(canvas.height - h), sea: read(h),
      hasSky: window.swellcast.camera.pitch > -15 };
  }, type);
}
