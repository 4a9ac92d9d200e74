// The mesh about the eye: every place is covered, and flat water lies over no waves, wherever the eye is.

import assert from 'node:assert/strict';
import test from 'node:test';
import { Grid } from '../viewer/grid.js';

/** A context that keeps what is drawn: of each call the ring, and its cells as x, z, width in the world. */
function recorder() {
  const drawn = [];
  let bound = null, ring = null, index = null;
  const gl = new Proxy({}, { get: (_, name) => {
    if (/^[A-Z0-9_]+$/.test(name)) return name;
    if (name === 'createVertexArray') return () => ({});
    if (name === 'bindVertexArray') return (array) => { bound = array ?? bound; };
    if (name === 'bufferData') return (target, data) => { if (target === 'ELEMENT_ARRAY_BUFFER') bound.indices = data; else bound.vertices = data; };
    if (name === 'uniform4f') return (at, x, z, cell) => { if (at === 'ring') { ring = { x, z, cell }; index = (index ?? -1) + 1; } };
    if (name === 'drawElements') {
      return (_mode, count, _type, offset) => {
        for (let i = offset / 2; i < offset / 2 + count; i += 6) {
          const corner = bound.indices[i];
          drawn.push({ index, x: ring.x + bound.vertices[corner * 2] * ring.cell, z: ring.z + bound.vertices[corner * 2 + 1] * ring.cell, cell: ring.cell });
        }
      };
    }
    return () => ({});
  } });
  return { gl, drawn, begin: () => { drawn.length = 0; index = null; } };
}

const WAVES = 10; // rings with waves; those after them are flat

test('every place is covered once, or twice where the flat water begins, and that is far from the eye', () => {
  const { gl, drawn, begin } = recorder(), cells = 64, grid = new Grid(gl, cells);
  const reach = 0.125 * 2 ** (WAVES - 1) * cells / 2; // of the last ring with waves
  const eyes = [[0, 0], [-0.004, -0.031], [0.004, 0.031], [-0.004, 0.031], [1023.9, -1023.9], [511, 513], [-700, 20], [123456.7, -98765.4]];
  for (const [x, z] of eyes) {
    begin();
    grid.moveTo(x, z);
    grid.draw({ uRing: 'ring' }, [x, 2, z], 2, () => true);
    for (let i = 0; i < 600; i++) {
      // Places ever farther from the eye, in all directions.
      const away = 0.01 * 1.022 ** i, angle = i * 2.39996;
      const px = x + away * Math.cos(angle) - grid.origin[0], pz = z + away * Math.sin(angle) - grid.origin[1];
      const there = drawn.filter((c) => px >= c.x && px < c.x + c.cell && pz >= c.z && pz < c.z + c.cell);
      const place = `${away.toFixed(2)} m from ${x}, ${z}`, flat = there.filter((c) => c.index >= WAVES).length;
      assert.ok(there.length >= 1, `nothing at ${place}`);
      assert.ok(there.length <= 1 || (flat === 1 && there.length === 2), `${there.length} cells at ${place}`);
      if (away < 0.49 * reach) assert.equal(flat, 0, `flat water at ${place}`);
    }
  }
});
