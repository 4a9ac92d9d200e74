// The three.js example, built and served here as a site of its own, in front of a running server: water is drawn, moves
// and carries the buoy, also after the context was lost and after a change of level.
//
//   (cd examples/three && npm install)
//   node test/browser/three.mjs --url http://127.0.0.1:8080/ --out three.png [--eye x,y,z] [--size 480,270]
//                               [--detail high] [--timeout 90] [--chromium PATH]

import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import { extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { deviation, difference, mean, run } from './chromium.mjs';

const EXAMPLE = fileURLToPath(new URL('../../examples/three', import.meta.url));
const TYPES = { '.html': 'text/html', '.js': 'text/javascript' };
const options = {
  out: { type: 'string', default: 'three.png' },
  eye: { type: 'string' },
  size: { type: 'string', default: '480,270' },
  detail: { type: 'string', default: 'low' },
};

await run(options, async (test) => {
  execFileSync(join(EXAMPLE, 'node_modules/.bin/vite'), ['build', '--logLevel', 'warn'], { cwd: EXAMPLE, stdio: 'inherit' });
  const site = await serve(join(EXAMPLE, 'dist'), new URL(test.args.url));
  try {
    test.args.url = `http://127.0.0.1:${site.address().port}/`;
    await look(test);
  } finally {
    site.close();
    site.closeAllConnections();
  }
});

async function look(test) {
  const { out, eye, size, detail } = test.args, [width, height] = size.split(',').map(Number);
  const page = await test.open(detail === 'low' ? { low: '' } : {});
  await page.setViewport({ width, height });
  await page.begin();
  await test.until(page, () => window.client?.playback?.foamy && window.buoy.visible);
  await page.evaluate((place) => {
    window.renderer.setAnimationLoop(null); // pictures are painted when they are asked for from here on
    if (place) window.camera.position.set(...place);
  }, eye?.split(',').map(Number));
  const first = await picture(page);
  writeFileSync(out, Buffer.from(first.png.split(',')[1], 'base64'));
  await new Promise((done) => setTimeout(done, 700));
  const second = await picture(page);
  const sky = mean(first.sky), sea = mean(first.sea);
  const apart = Math.hypot(...sky.map((v, i) => v - sea[i]));
  const contrast = deviation(first.sea), moved = difference(first.sea, second.sea);
  console.log(JSON.stringify({ out, apart, contrast, moved, buoy: [first.buoy, second.buoy], ms: first.ms }));
  test.check(apart > 20, `sky and sea look alike: ${apart}`);
  test.check(contrast > 4, `the sea is flat: deviation ${contrast}`);
  test.check(moved > 1, `the sea stands still: mean difference ${moved}`);
  for (const { y, height } of [first.buoy, second.buoy]) {
    test.check(Math.abs(y - height) < 1e-6, `the buoy is at ${y} m, the water at ${height} m`);
  }
  test.check(Math.abs(first.buoy.y - second.buoy.y) + Math.abs(first.buoy.level - second.buoy.level) > 1e-3, 'the buoy stands still');
  test.check(first.buoy.level > 0.5 && first.buoy.level < 1 - 1e-9, `the buoy does not tilt: ${first.buoy.level}`);
  test.check(first.error === 0 && second.error === 0, `WebGL error ${first.error}, ${second.error}`);

  await page.evaluate(() => window.renderer.forceContextLoss());
  await test.until(page, () => window.renderer.getContext().isContextLost());
  await page.evaluate(() => { window.renderer.forceContextRestore(); });
  await test.until(page, () => !window.renderer.getContext().isContextLost());
  const third = await picture(page);
  test.check(deviation(third.sea) > 4, `the sea is flat after the context was lost: ${deviation(third.sea)}`);
  test.check(third.error === 0, `WebGL error ${third.error} after the context was lost`);

  // Another subscription is another playback, and needs other textures: also when what is held is coarser than what comes.
  for (const level of [1, 0]) {
    await page.evaluate((wanted) => window.client.subscribe({ level: wanted }), level);
    await test.until(page, () => {
      const { client, paint } = window;
      paint(performance.now());
      return client.playback.plan.units[0].level === client.wish.level && client.playback.units[0][0].level === client.wish.level;
    });
    const changed = await picture(page);
    test.check(deviation(changed.sea) > 4, `the sea is flat at level ${level}: ${deviation(changed.sea)}`);
    test.check(changed.error === 0, `WebGL error ${changed.error} at level ${level}`);
  }

  // Marks a little above and below where the client says that the water is: seen from above, the water hides the latter.
  const marks = await page.evaluate(mark);
  const wrong = marks.filter(({ above, seen }) => above !== seen).length;
  test.check(wrong === 0, `${wrong} of ${marks.length} marks lie on the wrong side of the water that is drawn`);

  await page.begin();
  await test.until(page, () => window.client?.playback?.complete && window.buoy.visible);
  const left = await page.evaluate(() => {
    const { camera, client, renderer, scene, sea } = window;
    renderer.setAnimationLoop(null);
    scene.remove(sea);
    sea.dispose();
    renderer.render(scene, camera);
    const attached = client.playback.all().filter((unit) => unit.attached).length;
    client.close();
    return { attached, error: renderer.getContext().getError() };
  });
  test.check(left.attached === 0 && left.error === 0, `after the end: ${JSON.stringify(left)}`);
}

/** In the page: whether each of some flat marks is seen from above. */
function mark() {
  const { buoy, camera, paint, renderer, scene, sea } = window, gl = renderer.getContext();
  const OFF = 0.25; // metres
  const material = buoy.children[2].material.clone();
  material.color.set('#000');
  material.emissive.set('#f0f');
  buoy.scale.setScalar(1e-3);
  camera.position.set(0, 25, 0.01);
  camera.lookAt(0, 0, 0);
  window.controls.enabled = false;
  window.controls.target.set(0, 0, 0);
  const now = performance.now();
  paint(now);
  const marks = Array.from({ length: 40 }, (_, i) => {
    const mesh = buoy.children[2].clone(), above = i % 2 === 0, x = (i % 8 - 3.5) * 2.6, z = (Math.floor(i / 8) - 2) * 2.6;
    mesh.material = material;
    mesh.scale.set(1, 1e-3, 1);
    mesh.position.set(x, sea.heightAt(x, z) + (above ? OFF : -OFF), z);
    scene.add(mesh);
    return { mesh, above };
  });
  paint(now);
  return marks.map(({ mesh, above }) => {
    const at = mesh.position.clone().project(camera), rgba = new Uint8Array(4);
    gl.readPixels((at.x + 1) / 2 * gl.drawingBufferWidth, (at.y + 1) / 2 * gl.drawingBufferHeight, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    scene.remove(mesh);
    return { above, seen: rgba[0] > rgba[1] + 60 };
  });
}

/** Paints one picture, and reads it in the task that drew it: strips of sky (top) and of sea (bottom). */
function picture(page) {
  return page.evaluate(() => {
    const { buoy, client, paint, renderer, sea } = window, gl = renderer.getContext();
    const began = performance.now();
    paint(began);
    const { drawingBufferWidth: w, drawingBufferHeight: h } = gl, rows = Math.floor(h / 6);
    const read = (y) => {
      const out = new Uint8Array(w * rows * 4);
      gl.readPixels(0, y, w, rows, gl.RGBA, gl.UNSIGNED_BYTE, out);
      return Array.from(out.filter((_, i) => (i >> 2) % 5 === 0));
    };
    const strips = { sky: read(h - rows), sea: read(0) };
    const height = client.heightAt(buoy.position.x, buoy.position.z, sea.tick);
    return {
      ...strips, png: renderer.domElement.toDataURL('image/png'), ms: performance.now() - began, error: gl.getError(),
      buoy: { y: buoy.position.y, height, level: 1 - 2 * (buoy.quaternion.x ** 2 + buoy.quaternion.z ** 2) },
    };
  });
}

/** A site: files of a folder, and /v1 of a server, as a proxy in front of both would have it. */
function serve(folder, server) {
  const ask = (request, headers) => http.request({
    host: server.hostname, port: server.port, path: request.url, method: request.method, headers,
  });
  const site = http.createServer((request, answer) => {
    const { pathname } = new URL(request.url, 'http://site');
    if (pathname.startsWith('/v1/')) {
      request.pipe(ask(request, request.headers).on('response', (told) => {
        answer.writeHead(told.statusCode, told.headers);
        told.pipe(answer);
      }).on('error', () => answer.writeHead(502).end()));
      return;
    }
    try {
      const file = pathname === '/' ? '/index.html' : pathname;
      const body = readFileSync(join(folder, file));
      answer.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' }).end(body);
    } catch {
      answer.writeHead(pathname === '/favicon.ico' ? 204 : 404).end();
    }
  });
  site.on('upgrade', (request, socket, head) => {
    ask(request, request.headers).on('upgrade', (told, upstream, first) => {
      const lines = Object.entries(told.headers).map(([name, value]) => `${name}: ${value}`);
      socket.write(`HTTP/1.1 101 Switching Protocols\r\n${lines.join('\r\n')}\r\n\r\n`);
      socket.write(first);
      upstream.write(head);
      socket.pipe(upstream).pipe(socket);
      socket.on('error', () => upstream.destroy());
      upstream.on('error', () => socket.destroy());
    }).on('response', (told) => socket.end(`HTTP/1.1 ${told.statusCode} ${told.statusMessage}\r\n\r\n`))
      .on('error', () => socket.destroy()).end();
  });
  return new Promise((done) => site.listen(0, '127.0.0.1', () => done(site)));
}
