// The height of the water at one place, from the frames held: so that the eye stays above it.

const ROUNDS = 3; // of looking for the particle that is now at that place

/**
 * @param {import('./fields.js').Fields} fields already set to a moment
 * @param {number} x world position, metres
 * @param {number} z
 * @returns {number} metres above the rest surface, 0 where nothing is known
 */
export function waterHeight(fields, x, z) {
  let x0 = x, z0 = z;
  for (let round = 0; ; round++) {
    const [dx, height, dz] = displacement(fields, x0, z0);
    if (round === ROUNDS) return height;
    x0 = x - dx;
    z0 = z - dz;
  }
}

const sum = [0, 0, 0];

function displacement(fields, x0, z0) {
  sum.fill(0);
  fields.units.forEach(([unit], cascade) => {
    if (!unit) return;
    const { slots, weights, points } = unit.pick;
    for (let i = 0; i < points; i++) {
      for (const tile of unit.frames[slots[i]]) addTile(tile, x0 / fields.patches[cascade], z0 / fields.patches[cascade], weights[i]);
    }
  });
  return sum;
}

/** Bilinear in one tile; u and v in patches. Adds nothing if the sample lies in another tile. */
function addTile(tile, u, v, weight) {
  const { n, levelN, counts, step } = tile;
  const px = (u - Math.floor(u)) * levelN - tile.tileX * n, pz = (v - Math.floor(v)) * levelN - tile.tileZ * n;
  if (px < 0 || pz < 0 || px >= n || pz >= n) return;
  const ix = Math.floor(px), iz = Math.floor(pz), fx = px - ix, fz = pz - iz;
  // At a tile's far edge the neighbour belongs to the next tile: one tile a patch wraps, others hold.
  const jx = ix + 1 < n ? ix + 1 : levelN === n ? 0 : ix, jz = iz + 1 < n ? iz + 1 : levelN === n ? 0 : iz;
  for (let c = 0; c < 3; c++) {
    const at = (a, b) => counts[c * n * n + b * n + a];
    const low = at(ix, iz) * (1 - fx) + at(jx, iz) * fx, high = at(ix, jz) * (1 - fx) + at(jx, jz) * fx;
    sum[c] += weight * step[c] * (low * (1 - fz) + high * fz);
  }
}
