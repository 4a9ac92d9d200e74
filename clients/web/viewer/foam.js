// The pattern of foam: a tile of thresholds, evenly spread over 0 to 1, so that comparing it with a
// coverage c leaves a fraction c of the area white, as a lace of bubble rafts and holes.

const SIZE = 256;

/**
 * @param {import('../src/gl.js').Gpu} gpu
 * @returns {WebGLTexture}
 */
export function makeFoamTexture(gpu) {
  const { gl } = gpu;
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, Math.log2(SIZE) + 1, gl.R8, SIZE, SIZE);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, SIZE, SIZE, gl.RED, gl.UNSIGNED_BYTE, foamThresholds());
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  if (gpu.anisotropyName) gl.texParameterf(gl.TEXTURE_2D, gpu.anisotropyName, Math.min(8, gpu.anisotropy));
  gl.generateMipmap(gl.TEXTURE_2D);
  return texture;
}

/** @returns {Uint8Array} SIZE x SIZE, repeating in both directions, every value as frequent as any other */
export function foamThresholds() {
  const total = SIZE * SIZE;
  const raw = new Float32Array(total);
  addHoles(raw, 9, 0.55, 1);
  addHoles(raw, 23, 0.3, 2);
  addHoles(raw, 61, 0.15, 3);
  addClouds(raw, 0.5);
  // By rank: the distribution becomes even.
  const order = Uint32Array.from({ length: total }, (_, i) => i).sort((a, b) => raw[a] - raw[b]);
  const out = new Uint8Array(total);
  order.forEach((i, rank) => { out[i] = (rank * 256 / total) | 0; });
  return out;
}

/** Low along the walls between cells, high in their middles (Worley 1996: distance to second less first). */
function addHoles(raw, cells, weight, seed) {
  for (let y = 0; y < SIZE; y++) {
    for (let x = 0; x < SIZE; x++) {
      const px = (x / SIZE) * cells, py = (y / SIZE) * cells;
      const cx = Math.floor(px), cy = Math.floor(py);
      let first = 9, second = 9;
      for (let j = -1; j <= 1; j++) {
        for (let i = -1; i <= 1; i++) {
          const gx = (cx + i + cells) % cells, gy = (cy + j + cells) % cells;
          const dx = cx + i + hash(gx, gy, seed) - px, dy = cy + j + hash(gx, gy, seed + 50) - py;
          const d = Math.sqrt(dx * dx + dy * dy);
          if (d < first) { second = first; first = d; } else if (d < second) second = d;
        }
      }
      raw[y * SIZE + x] += weight * Math.min(1, second - first);
    }
  }
}

/** Smooth value noise of a few octaves. */
function addClouds(raw, weight) {
  for (let cells = 4, gain = weight / 2; cells <= 32; cells *= 2, gain /= 2) {
    for (let y = 0; y < SIZE; y++) {
      for (let x = 0; x < SIZE; x++) {
        const px = (x / SIZE) * cells, py = (y / SIZE) * cells;
        const ix = Math.floor(px), iy = Math.floor(py);
        const u = smooth(px - ix), v = smooth(py - iy);
        const at = (i, j) => hash((ix + i) % cells, (iy + j) % cells, 100 + cells);
        const low = at(0, 0) * (1 - u) + at(1, 0) * u, high = at(0, 1) * (1 - u) + at(1, 1) * u;
        raw[y * SIZE + x] += gain * 2 * (low * (1 - v) + high * v);
      }
    }
  }
}

function smooth(t) {
  return t * t * (3 - 2 * t);
}

function hash(x, y, seed) {
  let h = Math.imul(x, 0x27d4eb2d) ^ Math.imul(y, 0x165667b1) ^ Math.imul(seed, 0x9e3779b1);
  h = Math.imul(h ^ (h >>> 15), 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
  return ((h ^ (h >>> 16)) >>> 0) / 4294967296;
}
