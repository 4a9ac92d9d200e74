// The sea in a scene of three.js: a mesh about the camera, displaced and lit by the textures of `Fields`, and its sky.

import * as THREE from 'three';
import { Fields, meanSquareSlope } from '../src/fields.js';
import { gpuOf } from '../src/gl.js';
import { MOST_CASCADES } from '../src/playback.js';
import { SEA_FRAGMENT, SEA_VERTEX, SKY_FRAGMENT, SKY_VERTEX } from './glsl.js';

const UPLOADS_AHEAD = 4;
/** Metres, of the mesh's origin: a period of the lace of foam. */
const ORIGIN_STEP = 512;
/** Waves are displaced at least so far around. */
const WAVES_M = 2000;
const EYE = new THREE.Vector3();

/**
 * A mesh in a scene: it places itself about the camera, so nothing above it may move it but up and down.
 * @extends {THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>}
 */
export class Sea extends THREE.Mesh {
  /** @type {Fields | null} */
  #fields = null;
  /** The context was lost, and with it all textures. */
  #lost = () => {
    this.#all().forEach((unit) => { unit.attached = null; });
    this.#fields = null;
    this.gpu = gpuOf(this.gpu.gl, this.low);
  };

  /**
   * @param {import('../src/client.js').Client} client one that no other renderer draws from
   * @param {THREE.WebGLRenderer} renderer
   * @param {{size?: number, segments?: number, finest?: number, low?: boolean}} options metres across; cells across each
   *   of the rings that it is made of, a multiple of 8, at least 48; finest cell, metres, a power of two; spare a weak GPU
   */
  constructor(client, renderer, { size = 40_000, low = false, segments = low ? 48 : 96, finest = 0.25 } = {}) {
    if (segments % 8 !== 0 || segments < 48) throw new RangeError(`segments is ${segments}, must be a multiple of 8, at least 48`);
    if (!Number.isInteger(Math.log2(finest))) throw new RangeError(`finest is ${finest}, must be a power of two`);
    const rings = Math.max(1, Math.ceil(Math.log2(2 * WAVES_M / segments / finest)) + 1);
    const texture = () => ({ value: new THREE.ExternalTexture() });
    const uniforms = {
      ...THREE.UniformsUtils.clone(THREE.UniformsLib.fog),
      uDisplacement: texture(), uGradient: texture(), uMoment: texture(), uShear: texture(),
      uCount: { value: 0 },
      uLayer: { value: new Float32Array(MOST_CASCADES) },
      uLongest: { value: new Float32Array(MOST_CASCADES) },
      uPatch: { value: new Float32Array(MOST_CASCADES * 4) },
      uEye: { value: new THREE.Vector2() },
      uHs: { value: 2 },
      uSlopes: { value: 0 },
      uHaze: { value: 1 / 16000 },
      uSun: { value: new THREE.Vector3(0.5, 0.4, -0.8).normalize() },
      uSunColor: { value: new THREE.Color(3.6, 3.3, 2.9) },
      uHorizon: { value: new THREE.Color(0.5, 0.66, 0.84) },
      uZenith: { value: new THREE.Color(0.07, 0.2, 0.5) },
      uWater: { value: new THREE.Color(0.008, 0.045, 0.065) },
    };
    super(ringsOf(segments, finest, rings, size / 2), new THREE.ShaderMaterial({
      name: 'sea', vertexShader: SEA_VERTEX, fragmentShader: SEA_FRAGMENT, uniforms, fog: true, side: THREE.DoubleSide,
      defines: { MOST: MOST_CASCADES, CELLS: segments.toFixed(1), WAVES: (segments / 2 * finest * 2 ** (rings - 1)).toFixed(1) },
    }));
    this.client = client;
    this.renderer = renderer;
    this.low = low;
    this.gpu = gpuOf(/** @type {WebGL2RenderingContext} */ (renderer.getContext()), low);
    this.step = Math.max(ORIGIN_STEP, finest * 2 ** rings); // two of the widest cells
    this.tick = NaN;
    /** Unit vector towards the sun, radiance of the light, and what the water gives back: set them at will. */
    this.sun = uniforms.uSun.value;
    this.colors = { sun: uniforms.uSunColor.value, horizon: uniforms.uHorizon.value, zenith: uniforms.uZenith.value, water: uniforms.uWater.value };
    this.frustumCulled = false;
    this.geometry.setDrawRange(0, 0); // nothing before there is water
    renderer.domElement.addEventListener('webglcontextrestored', this.#lost);
  }

  /**
   * Goes to a moment: until the next call the scene shows the water of it. To be called once before each picture.
   * @param {number} now `performance.now()`, or the time that the picture is drawn for
   * @param {THREE.Camera} camera that the mesh is to be fine about
   */
  update(now, camera) {
    const { client, renderer, gpu: { gl } } = this, { playback } = client;
    this.tick = client.tick(now);
    if (!playback || !Number.isFinite(this.tick)) return;
    const target = renderer.getRenderTarget(), face = renderer.getActiveCubeFace(), mipmap = renderer.getActiveMipmapLevel();
    const { depth } = renderer.state.buffers, reversed = depth.getReversed();
    renderer.resetState();
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false); // before r184 that is left out
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    const fields = this.#textures(playback), wind = client.status?.wind;
    const from = (wind?.direction_from_deg ?? 0) * Math.PI / 180;
    fields.seek(this.tick, wind ? [Math.cos(from), Math.sin(from)] : [0, 0]);
    fields.uploadAhead(this.tick, UPLOADS_AHEAD);
    renderer.resetState();
    depth.setReversed(reversed); // which that forgets
    depth.setClear(1);
    renderer.setRenderTarget(target, face, mipmap);
    this.geometry.setDrawRange(0, playback.complete ? Infinity : 0);
    this.#place(fields, camera);
  }

  /**
   * The height of the water above a place of the world in the picture that is shown.
   * @param {number} x metres
   * @param {number} z
   * @returns {number} as `client.heightAt`
   */
  heightAt(x, z) {
    return this.client.heightAt(x, z, this.tick) + this.position.y;
  }

  /** What lies below the pointer is not known. */
  raycast() {}

  /** Lets go of everything on the GPU; the client goes on. */
  dispose() {
    this.renderer.domElement.removeEventListener('webglcontextrestored', this.#lost);
    this.#fields?.dispose();
    this.#all().forEach((unit) => unit.dispose());
    this.gpu.gl.deleteProgram(this.gpu.resolve?.program ?? null);
    this.#fields = null;
    this.geometry.dispose();
    this.material.dispose();
  }

  /** Units with textures: of what is drawn, and of what is held by now. */
  #all() {
    return [...this.#fields?.playback.all() ?? [], ...this.client.playback?.all() ?? []];
  }

  /**
   * Those of the sea that is held: anew when it is another, or the context is.
   * @param {import('../src/playback.js').Playback} playback
   */
  #textures(playback) {
    if (this.#fields?.playback === playback) return this.#fields;
    this.#fields?.dispose();
    this.#fields = new Fields(this.gpu, playback);
    const { uDisplacement, uGradient, uMoment, uShear } = this.material.uniforms;
    uDisplacement.value.sourceTexture = this.#fields.displacement;
    uGradient.value.sourceTexture = this.#fields.gradient;
    uMoment.value.sourceTexture = this.#fields.moment;
    uShear.value.sourceTexture = this.#fields.shear;
    return this.#fields;
  }

  /** @param {Fields} fields @param {THREE.Camera} camera */
  #place(fields, camera) {
    const { playback, longest } = fields, { uniforms: u } = this.material, { status } = this.client, eye = EYE.setFromMatrixPosition(camera.matrixWorld);
    this.position.x = Math.floor(eye.x / this.step) * this.step;
    this.position.z = Math.floor(eye.z / this.step) * this.step;
    u.uEye.value.set(eye.x - this.position.x, eye.z - this.position.z);
    u.uCount.value = playback.active.length;
    playback.active.forEach((layer, i) => {
      u.uLayer.value[i] = layer;
      u.uLongest.value[i] = longest[layer];
      u.uPatch.value.set(fields.placeOf(layer, this.position.x, this.position.z), i * 4);
    });
    u.uHs.value = Math.max(0.5, status?.hs_m ?? 2);
    u.uSlopes.value = meanSquareSlope(status?.wind?.speed_mps ?? null);
  }
}

/** The sky that a sea mirrors, behind all else of its scene. @extends {THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>} */
export class Sky extends THREE.Mesh {
  /** @param {Sea} sea whose sun and colours it has */
  constructor({ material: { uniforms } }) {
    super(new THREE.SphereGeometry(1, 8, 8), new THREE.ShaderMaterial({
      name: 'sky', uniforms, side: THREE.BackSide, depthTest: false, depthWrite: false,
      vertexShader: SKY_VERTEX, fragmentShader: SKY_FRAGMENT,
    }));
    this.frustumCulled = false;
    this.renderOrder = -1;
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

/**
 * Square rings about the eye, each with cells twice as wide as the one inside it: a vertex is its place in a ring, and
 * the width of its cells. A ring lies on multiples of two of its cells: its hole is what the inner one covers wherever
 * the eye is, and where both are drawn they agree. Around the last lies flat water, to the horizon.
 * @param {number} cells across
 * @param {number} finest metres
 * @param {number} rings
 * @param {number} horizon metres
 */
function ringsOf(cells, finest, rings, horizon) {
  /** @type {number[]} */
  const vertices = [];
  /** @type {number[]} */
  const indices = [];
  /** @type {(lines: number[], cell: number, covered: (i: number) => boolean) => void} */
  const add = (lines, cell, covered) => {
    const side = lines.length;
    lines.forEach((z, row) => lines.forEach((x, column) => {
      const v = vertices.push(x, cell, z) / 3 - 1;
      if (row + 1 === side || column + 1 === side || (covered(x) && covered(z))) return;
      indices.push(v, v + side, v + 1, v + 1, v + side, v + side + 1);
    }));
  };
  const lines = Array.from({ length: cells + 1 }, (_, i) => i), widest = finest * 2 ** (rings - 1);
  for (let ring = 0; ring < rings; ring++) {
    add(lines, finest * 2 ** ring, (i) => ring > 0 && i > cells / 4 && i < cells * 0.75);
  }
  const far = 2 * Math.ceil(horizon / widest / 2);
  add([-far, 2, cells - 2, cells + far], widest, (i) => i === 2);
  const positions = new THREE.Float32BufferAttribute(vertices, 3);
  return new THREE.BufferGeometry().setAttribute('position', positions).setIndex(indices);
}
