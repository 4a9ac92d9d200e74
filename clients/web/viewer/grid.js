// The mesh: square rings about the eye, each with cells twice as wide as the one inside it.
//
// Rings sit on multiples of two of their own cells, so vertices never slide through the water. Odd
// vertices move onto their even neighbours towards the outer edge (Strugar 2010), where the ring has
// then become the next one: no cracks, no pops. All positions are relative to an origin near the
// eye, in multiples of a power of two: exact in single precision, so shared edges agree in every bit.

const BLOCKS = 4; // across, for culling
const LEVELS = 10;
const FAR_LEVELS = 5; // flat water beyond, to the horizon, in far fewer cells
const FAR_CELLS = 16;
const FINEST = 0.125; // metres
const ORIGIN_STEP = 1024;
/** Eye height at which the finest ring starts to be left out. */
const FULL_HEIGHT = 12;
const MORPH_START = 0.62; // of half a ring
/** Where the inner ring lies: off the middle by x, z cells; and how far the two overlap, in cells. */
const HOLES = [null, ...[0, 1].flatMap((overlap) => [[0, 0, overlap], [1, 0, overlap], [0, 1, overlap], [1, 1, overlap]])];
/** Of holes: the first within whose cells the inner ring lies, and the first of those that lie about anywhere. */
const FITTING = 1, ABOUT = 5;

export class Grid {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {number} cells across a ring, a multiple of 16, at most 240
   */
  constructor(gl, cells) {
    this.gl = gl;
    this.near = makeRings(gl, cells);
    this.far = makeRings(gl, FAR_CELLS);
    this.origin = [0, 0];
    this.drawn = 0;
  }

  /** Chooses the origin for an eye; positions in shaders are relative to it. */
  moveTo(eyeX, eyeZ) {
    this.origin[0] = Math.floor(eyeX / ORIGIN_STEP) * ORIGIN_STEP;
    this.origin[1] = Math.floor(eyeZ / ORIGIN_STEP) * ORIGIN_STEP;
  }

  /**
   * @param {Record<string, WebGLUniformLocation>} at uniforms uRing, uMorph, uCalm of the water
   * @param {number[]} eye world position
   * @param {number} reach how far a vertex may be displaced, metres
   * @param {(box: number[]) => boolean} sees whether a box relative to the eye may be in view
   */
  draw(at, eye, reach, sees) {
    const { gl, origin, box = (this.box = new Array(6)) } = this;
    const height = Math.max(0, Math.log2(Math.max(1e-3, Math.abs(eye[1])) / FULL_HEIGHT));
    const first = Math.min(LEVELS - 2, Math.floor(height));
    const last = first + LEVELS;
    // Waves end where the flat water begins.
    const calm = FINEST * 2 ** (last - 1) * this.near.cells / 2;
    gl.uniform2f(at.uCalm, 0.55 * calm, 0.9 * calm);
    this.drawn = 0;
    let innerX = 0, innerZ = 0;
    for (let level = first; level < last + FAR_LEVELS; level++) {
      const rings = level < last ? this.near : this.far;
      const half = FINEST * 2 ** level * this.near.cells / 2;
      const cell = 2 * half / rings.cells;
      const x = Math.floor(eye[0] / (2 * cell)) * 2 * cell, z = Math.floor(eye[2] / (2 * cell)) * 2 * cell;
      let hole = 0;
      if (level > first) hole = (level === last ? ABOUT : FITTING) + (innerX - x >= cell ? 1 : 0) + (innerZ - z >= cell ? 2 : 0);
      innerX = x;
      innerZ = z;
      gl.bindVertexArray(rings.array);
      gl.uniform4f(at.uRing, x - origin[0] - half, z - origin[1] - half, cell,
        level === first ? Math.min(1, height - first) : 0);
      gl.uniform2f(at.uMorph, MORPH_START * half, 1 / ((morphEnd(rings.cells) - MORPH_START) * half));
      const wide = 2 * half / BLOCKS;
      for (let b = 0; b < BLOCKS * BLOCKS; b++) {
        const { offset, count } = rings.ranges[hole][b];
        if (count === 0) continue;
        const left = x - half + (b % BLOCKS) * wide - eye[0], back = z - half + Math.floor(b / BLOCKS) * wide - eye[2];
        box[0] = left - reach; box[1] = -eye[1] - reach; box[2] = back - reach;
        box[3] = left + wide + reach; box[4] = -eye[1] + reach; box[5] = back + wide + reach;
        if (!sees(box)) continue;
        gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_SHORT, offset);
        this.drawn += count / 3;
      }
    }
    gl.bindVertexArray(null);
  }
}

/** Odd vertices must have moved wholly where the next ring begins, two cells before the edge at worst. */
function morphEnd(cells) {
  return 1 - 6 / cells;
}

/** Vertices and index ranges of one ring: by hole and block. */
function makeRings(gl, cells) {
  const side = cells + 1, half = cells / 2, block = cells / BLOCKS;
  const vertices = new Uint8Array(side * side * 2);
  for (let i = 0; i < side * side; i++) vertices.set([i % side, (i / side) | 0], i * 2);
  const indices = [];
  const ranges = HOLES.map((hole) => {
    const inside = (cell, shift) => hole !== null && cell >= half / 2 + shift + hole[2] && cell < half * 1.5 + shift - hole[2];
    const blocks = [];
    for (let b = 0; b < BLOCKS * BLOCKS; b++) {
      const first = indices.length;
      const x0 = (b % BLOCKS) * block, z0 = Math.floor(b / BLOCKS) * block;
      for (let z = z0; z < z0 + block; z++) {
        for (let x = x0; x < x0 + block; x++) {
          if (hole && inside(x, hole[0]) && inside(z, hole[1])) continue;
          const a = z * side + x, c = a + side;
          indices.push(a, c, a + 1, a + 1, c, c + 1);
        }
      }
      blocks.push({ offset: first * 2, count: indices.length - first });
    }
    return blocks;
  });
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.UNSIGNED_BYTE, false, 0, 0);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(indices), gl.STATIC_DRAW);
  gl.bindVertexArray(null);
  return { cells, array, ranges };
}
