// The sea at one moment as filterable textures: joins the frames of a playback in time, on the GPU.
//
// One texture array each, a layer per cascade:
//   displacement  dx, height, dz, -           metres, for vertices
//   gradient      hx, hz, Dxx, Dzz            for the exact normal
//   moment        hx^2, hz^2, hx hz, foam     what mipmaps of slopes lose, they keep: E[s s^T]
//   shear         Dxz

import { GROUPS } from './frame.js';
import { bindTexture, COVER_VERTEX, makeProgram } from './gl.js';
import { Unit } from './unit.js';
import { FrameTexture } from './upload.js';

const CHANNELS = 9;
/** Step of the spread of foam along crests, in the longest waves of a cascade. */
const SMEAR_WAVES = 0.065;
/** The groups that textures are made of, the first of the protocol, and the first channel of each. */
const DRAWN = GROUPS.slice(0, 4);
const FIRST_CHANNEL = [0, 3, 5, 8];

const RESOLVE = `
precision highp isampler2DArray;
uniform isampler2DArray uDisplacement, uSlopes, uDerivatives, uFoam;
uniform ivec4 uSlots[4];   // by group: where the four frames lie
uniform vec4 uWeights[${CHANNELS}]; // by channel: weight in time, times metres a count
uniform ivec4 uCoarser;    // by group: samples of the target per sample of the frames
uniform vec2 uSmear;       // a step of foam along the crests, in samples of the target
layout(location = 0) out vec4 oDisplacement;
layout(location = 1) out vec4 oGradient;
layout(location = 2) out vec4 oMoment;
layout(location = 3) out vec4 oShear;

vec4 counts(isampler2DArray frames, ivec4 layer, ivec2 p) {
  return vec4(texelFetch(frames, ivec3(p, layer.x), 0).r, texelFetch(frames, ivec3(p, layer.y), 0).r,
              texelFetch(frames, ivec3(p, layer.z), 0).r, texelFetch(frames, ivec3(p, layer.w), 0).r);
}

float field(isampler2DArray frames, ivec4 slots, int coarser, int channels, int channel, vec4 weights, ivec2 p) {
  ivec4 layer = slots * channels + channel;
  ivec2 n = textureSize(frames, 0).xy;
  p = (p + n * coarser) % (n * coarser);
  if (coarser == 1) return dot(weights, counts(frames, layer, p));
  ivec2 a = p / coarser, b = (a + 1) % n;
  vec2 f = vec2(p - a * coarser) / float(coarser);
  vec4 c = mix(mix(counts(frames, layer, a), counts(frames, layer, ivec2(b.x, a.y)), f.x),
               mix(counts(frames, layer, ivec2(a.x, b.y)), counts(frames, layer, b), f.x), f.y);
  return dot(weights, c);
}

/** Breakers are longer than the waves of one cascade tell: foam is spread along crests, its mean kept. */
float foam(ivec2 p) {
  float sum = 0.0;
  for (int i = -3; i <= 3; i++) {
    float share = 0.25 * (1.0 - abs(float(i)) / 4.0);
    ivec2 q = p + ivec2(round(float(i) * uSmear));
    sum += share * clamp(field(uFoam, uSlots[3], uCoarser.w, 1, 0, uWeights[8], q), 0.0, 1.0);
  }
  return sum;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec2 slope = vec2(field(uSlopes, uSlots[1], uCoarser.y, 2, 0, uWeights[3], p),
                    field(uSlopes, uSlots[1], uCoarser.y, 2, 1, uWeights[4], p));
  oDisplacement = vec4(field(uDisplacement, uSlots[0], uCoarser.x, 3, 0, uWeights[0], p),
                       field(uDisplacement, uSlots[0], uCoarser.x, 3, 1, uWeights[1], p),
                       field(uDisplacement, uSlots[0], uCoarser.x, 3, 2, uWeights[2], p), 0.0);
  oGradient = vec4(slope, field(uDerivatives, uSlots[2], uCoarser.z, 3, 0, uWeights[5], p),
                          field(uDerivatives, uSlots[2], uCoarser.z, 3, 1, uWeights[6], p));
  oShear = vec4(field(uDerivatives, uSlots[2], uCoarser.z, 3, 2, uWeights[7], p));
  oMoment = vec4(slope * slope, slope.x * slope.y, foam(p));
}`;

/**
 * Mean square slope of the whole sea, both ways together (Cox & Munk 1954; wind at 12.5 m taken as that at 10 m).
 * @param {number | null} windMps null where the sea is not wind-driven
 */
export function meanSquareSlope(windMps) {
  return windMps === null ? 0 : 0.003 + 5.12e-3 * windMps;
}

export class Fields {
  /**
   * @param {import('./gl.js').Gpu} gpu
   * @param {import('./playback.js').Playback} playback of counts: codecs `rans` and `i16`; drawn by one context alone
   * @throws {TypeError} frames that are not counts
   */
  constructor(gpu, playback) {
    if (playback.plan.units.some(({ codec }) => codec === 'f16' || codec === 'f32')) {
      throw new TypeError('textures are made of counts: codec must be rans or i16');
    }
    const { gl } = gpu;
    this.gpu = gpu;
    this.playback = playback;
    this.patches = playback.cascades.map((c) => c.patch_m);
    this.longest = playback.cascades.map((c) => c.wavelength_max_m);
    // What is held now may be coarser than what comes, or finer.
    const granted = playback.plan.units.map(({ cascade, level }) => (playback.cascades.find(({ index }) => index === cascade)?.n ?? 0) >>> level);
    this.size = Math.max(8, ...granted, ...playback.all().map((unit) => unit.size));
    this.tick = NaN;
    this.nextAhead = 0;

    const wide = gpu.float32 ? gl.RGBA32F : gl.RGBA16F;
    this.displacement = this.#target(wide, false);
    this.gradient = this.#target(gl.RGBA16F, true);
    this.moment = this.#target(gl.RGBA16F, true);
    this.shear = this.#target(gl.R16F, true);
    this.targets = this.patches.map((_, layer) => {
      const frame = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
      [this.displacement, this.gradient, this.moment, this.shear].forEach((texture, i) => {
        gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, texture, 0, layer);
      });
      gl.drawBuffers([0, 1, 2, 3].map((i) => gl.COLOR_ATTACHMENT0 + i));
      return frame;
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    // Another subscription has other textures, and the same program: compiling it would hold up a picture.
    this.pass = gpu.resolve ??= makeProgram(gl, 'resolve', COVER_VERTEX, RESOLVE);
    this.slots = new Int32Array(16);
    this.weights = new Float32Array(4 * CHANNELS);
    this.coarser = new Int32Array(4);
    this.empty = new Unit(0, 1, 8, 480, 0); // stands in where nothing is subscribed
  }

  /**
   * Sets the textures to a moment. Leaves another framebuffer, program, viewport and textures bound than it found.
   * @param {number} tick
   * @param {number[]} crestwise x, z: unit vector along the crests, or zero
   * @returns {boolean} starved: some unit has no frame on one side of that moment
   */
  seek(tick, crestwise) {
    const { playback } = this;
    const starved = playback.seek(tick);
    if (tick === this.tick) return starved;
    this.tick = tick;
    const { gl } = this.gpu;
    gl.useProgram(this.pass.program);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.viewport(0, 0, this.size, this.size);
    for (const layer of playback.active) this.#resolve(layer, crestwise);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.activeTexture(gl.TEXTURE0);
    for (const texture of [this.displacement, this.gradient, this.moment, this.shear]) {
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
    }
    return starved;
  }

  /**
   * Uploads a few frames before they are needed, so that no single drawing pays for all.
   * @param {number} tick
   * @param {number} most
   */
  uploadAhead(tick, most) {
    const { gl } = this.gpu;
    gl.activeTexture(gl.TEXTURE0);
    const all = this.playback.all().filter((unit) => unit.group < DRAWN.length);
    for (let i = 0; i < all.length && most > 0; i++) {
      const unit = all[this.nextAhead++ % all.length];
      if (FrameTexture.of(gl, unit).uploadAhead(tick)) most--;
    }
  }

  /**
   * Where a place of the world lies in a layer's textures: u, v, patches a metre, samples a metre.
   * @param {number} layer
   * @param {number} x metres
   * @param {number} z
   * @returns {[number, number, number, number]}
   */
  placeOf(layer, x, z) {
    const each = 1 / this.patches[layer];
    // Sample (0, 0) stands for the origin and lies in the middle of its texel.
    const at = (/** @type {number} */ v) => v * each - Math.floor(v * each) + 0.5 / this.size;
    return [at(x), at(z), each, this.size * each];
  }

  /** Lets go of the textures; the playback's frames, and what of them lies on the GPU, stay. */
  dispose() {
    const { gl } = this.gpu;
    this.empty.dispose();
    for (const t of [this.displacement, this.gradient, this.moment, this.shear]) gl.deleteTexture(t);
    for (const f of this.targets) gl.deleteFramebuffer(f);
  }

  /** @param {number} layer @param {number[]} crestwise */
  #resolve(layer, crestwise) {
    const { gl } = this.gpu, { at } = this.pass, units = this.playback.units[layer];
    this.slots.fill(0);
    this.weights.fill(0);
    this.coarser.fill(1);
    [at.uDisplacement, at.uSlopes, at.uDerivatives, at.uFoam].forEach((location, group) => {
      gl.activeTexture(gl.TEXTURE0 + group); // an upload binds: not in the place of another group
      const unit = units[group], frames = FrameTexture.of(gl, unit ?? this.empty);
      frames.upload();
      bindTexture(gl, group, gl.TEXTURE_2D_ARRAY, frames.texture, location);
      if (!unit) return;
      this.coarser[group] = this.size / unit.size;
      const { slots, weights, points } = unit.pick;
      for (let i = 0; i < points; i++) {
        this.slots[group * 4 + i] = slots[i];
        for (let c = 0; c < unit.channels; c++) {
          this.weights[(FIRST_CHANNEL[group] + c) * 4 + i] = weights[i] * unit.step(slots[i], c);
        }
      }
    });
    gl.uniform4iv(at.uSlots, this.slots);
    gl.uniform4fv(at.uWeights, this.weights);
    gl.uniform4iv(at.uCoarser, this.coarser);
    const step = SMEAR_WAVES * this.longest[layer] / this.patches[layer] * this.size;
    gl.uniform2f(at.uSmear, crestwise[0] * step, crestwise[1] * step);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[layer]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** @param {number} format @param {boolean} anisotropic */
  #target(format, anisotropic) {
    const { gl, anisotropy, anisotropyName } = this.gpu;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, Math.log2(this.size) + 1, format, this.size, this.size, this.patches.length);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    if (anisotropic && anisotropyName) gl.texParameterf(gl.TEXTURE_2D_ARRAY, anisotropyName, anisotropy);
    return texture;
  }
}
