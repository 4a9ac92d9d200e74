// A WebXR session in the viewer, in a headset that the iwer emulator makes up: enters, both eyes are drawn and differ,
// the deck floats and carries the wearer, a teleport leads overboard, and the page goes on after it.
//
//   node test/browser/xr.mjs --url http://127.0.0.1:8080/ [--out FOLDER] [--detail high]

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deviation, difference, run } from './chromium.mjs';

const IWER = readFileSync(new URL('../../node_modules/iwer/build/iwer.min.js', import.meta.url), 'utf8');

await run({ out: { type: 'string' }, detail: { type: 'string', default: 'low' } }, async (test) => {
  const page = await test.viewer({ still: '0', detail: test.args.detail }, async (fresh) => {
    await fresh.evaluateOnNewDocument(`${IWER};
      window.headset = new IWER.XRDevice(IWER.metaQuest3);
      headset.installRuntime({ forceInstall: true }); /* Chromium's own knows no headset */
      headset.stereoEnabled = true;`);
  });
  await test.until(page, () => !document.getElementById('vr').hidden);
  await page.evaluate(() => { document.getElementById('panel').open = true; });
  await page.click('#enter');
  await test.until(page, () => window.swellcast.immersion);
  const first = await picture(page);
  test.check(first.eyes.length === 2, `${first.eyes.length} eyes`);
  const contrasts = first.eyes.map(({ pixels }) => deviation(pixels)), apart = difference(first.eyes[0].pixels, first.eyes[1].pixels);
  console.log(JSON.stringify({ sizes: first.eyes.map(({ width, height }) => [width, height]), contrasts, apart, deck: first.deck }));
  first.eyes.forEach(({ width, height }, i) => {
    test.check(width > 100 && height > 100, `an eye of ${width} x ${height}`);
    test.check(contrasts[i] > 3, `an eye sees nothing: deviation ${contrasts[i]}`);
  });
  test.check(apart > 0.5, `both eyes see the same: ${apart}`);
  test.check(first.distance > 0.05 && first.distance < 0.08, `eyes are ${first.distance} m apart`);
  test.check(Math.abs(first.height - first.deck.y - 1.6) < 0.9, `eyes at ${first.height} m, deck at ${first.deck.y} m`);
  if (test.args.out) {
    for (const [i, name] of ['left', 'right'].entries()) {
      writeFileSync(join(test.args.out, `viewer-vr-${name}.jpg`), Buffer.from(first.eyes[i].image.split(',')[1], 'base64'));
    }
  }

  // The deck goes with the water: other pictures, other heights, the same as everybody computes.
  await page.evaluate(() => new Promise((done) => setTimeout(done, 900)));
  const second = await picture(page);
  test.check(Math.abs(second.deck.y - first.deck.y) > 1e-3, 'the deck stands still');
  test.check(Math.abs(second.level) < 1e-6, `the horizon tilts by ${second.level}`);

  // Points at the water ahead of the boat, and lets go.
  const before = second.place;
  await page.evaluate(() => {
    const { right } = headset.controllers;
    right.position.set(0.2, 1.3, -0.3);
    right.quaternion.set(Math.sin(-0.06), 0, 0, Math.cos(-0.06));
    right.updateButtonValue('trigger', 1);
  });
  const aimed = await picture(page);
  test.check(aimed.target !== null, 'the controller points at nothing');
  await page.evaluate(() => headset.controllers.right.updateButtonValue('trigger', 0));
  const there = await picture(page);
  const went = Math.hypot(there.place[0] - before[0], there.place[2] - before[2]);
  console.log(JSON.stringify({ target: aimed.target, went, floor: there.floor }));
  test.check(went > 5 && there.floor === 'sea', `the teleport went ${went} m, to the ${there.floor}`);

  // The loops: one picture for each of the headset's while it is worn, and of the page's after it, also the second time.
  const immersed = await page.evaluate(loops, true);
  for (let round = 0; round < 2; round++) {
    await page.evaluate(() => window.swellcast.immersion.session.end());
    await test.until(page, () => !window.swellcast.immersion);
    if (round === 0) {
      await page.click('#enter');
      await test.until(page, () => window.swellcast.immersion);
    }
  }
  const after = await page.evaluate(loops, false), { refused } = await page.evaluate(() => window.swellcast.client.counts);
  console.log(JSON.stringify({ immersed, after }));
  test.check(immersed.pictures === immersed.frames, `in VR ${immersed.pictures} pictures in ${immersed.frames} frames`);
  test.check(after.pictures === after.frames, `after VR ${after.pictures} pictures in ${after.frames} frames`);
  test.check(refused === 0, `${refused} frames refused`);
});

/** In the page: how many pictures are painted within some frames of the headset, or of the page. */
function loops(inHeadset) {
  const { swellcast } = window, ask = inHeadset ? swellcast.immersion.session : window;
  const FRAMES = 5;
  return new Promise((done) => {
    let frames = 0, before = 0;
    const next = () => {
      if (frames === 0) {
        swellcast.held = false;
        before = swellcast.pictures;
      }
      if (frames++ < FRAMES) return ask.requestAnimationFrame(next);
      swellcast.held = true;
      done({ frames: FRAMES, pictures: swellcast.pictures - before });
    };
    ask.requestAnimationFrame(next);
  });
}

/** One picture in the headset: what each eye sees, and where all is. */
async function picture(page) {
  return page.evaluate(() => new Promise((done) => {
    const { swellcast } = window, { immersion } = swellcast;
    // After one frame in which the emulator takes up what was set, the next is painted and read at once.
    immersion.session.requestAnimationFrame(() => immersion.session.requestAnimationFrame((now, frame) => {
      swellcast.paint(now, frame);
      const { gl } = swellcast.renderer.gpu, { baseLayer } = immersion.session.renderState;
      gl.bindFramebuffer(gl.FRAMEBUFFER, baseLayer.framebuffer);
      const eyes = frame.getViewerPose(immersion.space).views.map((view) => {
        const { x, y, width, height } = baseLayer.getViewport(view);
        const pixels = new Uint8Array(width * height * 4);
        gl.readPixels(x, y, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        const canvas = Object.assign(document.createElement('canvas'), { width, height }), context = canvas.getContext('2d');
        const image = context.createImageData(width, height);
        for (let row = 0; row < height; row++) image.data.set(pixels.subarray((height - 1 - row) * width * 4, (height - row) * width * 4), row * width * 4);
        context.putImageData(image, 0, 0);
        return { x, y, width, height, pixels: Array.from(pixels.filter((_, i) => (i >> 2) % 7 === 0)), image: canvas.toDataURL('image/jpeg', 0.9) };
      });
      const [a, b] = immersion.views, { deck } = { deck: { y: 0 }, ...immersion };
      done({
        eyes, distance: Math.hypot(...a.eye.map((v, i) => v - b.eye[i])), height: a.eye[1],
        level: a.turn[1], deck: { y: deck.y, pitch: deck.pitch, roll: deck.roll }, place: immersion.place, floor: immersion.floor, target: immersion.target,
      });
    }));
  }));
}
