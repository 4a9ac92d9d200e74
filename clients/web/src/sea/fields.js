// The sea at one moment: joins the frames of every cascade in time and gives filterable textures.
//
// One texture array each, a layer per cascade. While the layout changes there are cascades of two; each counts at
// its own ticks alone, so none begins or ends with a step.
//   displacement  dx, height, dz, -           metres, for vertices
//   gradient      hx, hz, Dxx, Dzz            for the exact normal
//   moment        hx^2, hz^2, hx hz, foam     what mipmaps of slopes lose, they keep: E[s s^T]
//   shear         Dxz

import { GROUP_CHANNELS, GROUPS } from '../frame.js';
import { isThere, REST_TICKS, TICKS_PER_SECOND } from '../messages.js';
import { bindTexture, COVER_VERTEX, makeProgram } from './gl.js';
import { Unit } from './unit.js';

/** Most cascades: eight of a layout, and eight of the one that follows it. */
export const MOST_CASCADES = 16;
const CHANNELS = 9;
/** Step of the spread of foam along crests, in the longest waves of a cascade. */
const SMEAR_WAVES = 0.065;
/** The groups that are drawn, the first of the protocol, and the first channel of each. */
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
    sum += share * clamp(field(uFoam, uSlots[3], uCoarser.w, 1, 0, uWeights[8], p + ivec2(round(float(i) * uSmear))), 0.0, 1.0);
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

export class Fields {
  /**
   * @param {import('./gl.js').Gpu} gpu
   * @param {object} layout of `hello`
   * @param {import('../plan.js').Plan} plan
   * @param {Fields | null} before of the same sea: frames of cascades that go on are taken from there
   */
  constructor(gpu, layout, plan, before = null) {
    const { gl } = gpu;
    this.gpu = gpu;
    this.plan = plan;
    this.interval = TICKS_PER_SECOND / plan.rateHz;
    this.cascades = layout.cascades.slice(0, MOST_CASCADES);
    this.patches = this.cascades.map((c) => c.patch_m);
    this.longest = this.cascades.map((c) => c.wavelength_max_m);
    this.count = this.cascades.length;
    /** units by layer, then group; null where none is subscribed */
    this.units = this.cascades.map(() => DRAWN.map(() => null));
    /** the same at another level, of which frames come that are not shown yet */
    this.coming = this.cascades.map(() => DRAWN.map(() => null));
    /** finest level that comes, where a unit is subscribed */
    this.finestLevel = this.cascades.map(() => DRAWN.map(() => 0));
    this.size = 8;
    this.layers = new Map(this.cascades.map((c, layer) => [c.index, layer]));
    for (const u of plan.units) {
      const group = DRAWN.indexOf(u.group), layer = this.layers.get(u.cascade);
      if (layer === undefined || group < 0) continue;
      const cascade = this.cascades[layer], size = cascade.n >> u.level;
      const interval = TICKS_PER_SECOND / (u.rate_hz ?? plan.rateHz);
      this.size = Math.max(this.size, size);
      this.finestLevel[layer][group] = u.level;
      this.units[layer][group] = before?.take(cascade, group, u.level, interval)
        ?? new Unit(gl, GROUP_CHANNELS[group], size, interval, u.level);
    }
    this.tick = -1;
    /** every cascade has displacement, slopes and derivatives; once so, one that is added begins as nothing */
    this.complete = before?.complete ?? false;
    this.foamy = false; // and foam
    this.active = []; // layers that are part of the sea at the moment
    this.finest = 0; // of those, the one with the shortest waves
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
    this.pass = makeProgram(gl, 'resolve', COVER_VERTEX, RESOLVE);
    this.slots = new Int32Array(16);
    this.weights = new Float32Array(4 * CHANNELS);
    this.coarser = new Int32Array(4);
    this.empty = new Unit(gl, 1, 8, this.interval, 0); // stands in where nothing is subscribed
  }

  /**
   * @param {import('../decode.js').DecodedFrame} frame
   * @returns {boolean} whether it was of use
   */
  accept(frame) {
    const layer = this.layers.get(frame.cascade), { group, level, levelN } = frame;
    const unit = this.units[layer]?.[group];
    if (!unit) return false;
    if (unit.level === level) return unit.accept(frame);
    // The server sends it coarser than it was granted, or fine again.
    const { n } = this.cascades[layer], coming = this.coming[layer];
    if (coming[group]?.level !== level) {
      if (level < this.finestLevel[layer][group] || level >= 32 || n >>> level !== levelN) return false;
      coming[group]?.dispose();
      coming[group] = new Unit(this.gpu.gl, unit.channels, levelN, unit.ring.interval, level);
    }
    return coming[group].accept(frame);
  }

  /** Every unit that is held. */
  all() {
    return [...this.units.flat(), ...this.coming.flat()].filter(Boolean);
  }

  /** The levels that are shown, the finest first. */
  levels() {
    return [...new Set(this.units.flat().filter(Boolean).map((unit) => unit.level))].sort((a, b) => a - b);
  }

  /**
   * Gives away a unit of a cascade that goes on, with its frames; undefined when there is none that fits. It may be
   * coarser than what will come.
   */
  take(cascade, group, level, interval) {
    const layer = this.layers.get(cascade.index);
    const unit = this.units[layer]?.[group];
    if (!unit || this.cascades[layer].from_tick !== cascade.from_tick) return undefined;
    if (this.finestLevel[layer][group] !== level || unit.ring.interval !== interval) return undefined;
    this.units[layer][group] = null;
    return unit;
  }

  /** Chooses the layers of a moment, and lets go of those that are over. */
  #choose(tick) {
    this.active.length = 0;
    let lasting = -1, ending = -1;
    this.cascades.forEach((cascade, layer) => {
      if (isThere(cascade, tick)) {
        this.active.push(layer);
        if (cascade.until_tick === null) lasting = layer; else ending = layer;
        return;
      }
      const over = tick >= cascade.from_tick;
      this.units[layer].forEach((unit, group) => {
        if (!unit) return;
        unit.pick.points = 0;
        if (!over) return;
        for (const held of [this.units, this.coming]) {
          held[layer][group]?.dispose();
          held[layer][group] = null;
        }
      });
    });
    this.finest = lasting < 0 ? ending : lasting;
    if (lasting >= 0 && ending >= 0) {
      const middle = (this.cascades[lasting].from_tick + this.cascades[ending].until_tick) / 2;
      if (tick < middle) this.finest = ending;
    }
  }

  /**
   * Sets the textures to a moment.
   * @param {number} tick
   * @param {number[]} crestwise x, z: unit vector along the crests, or zero
   * @returns {boolean} starved: some unit had no frame on one side of that moment
   */
  seek(tick, crestwise) {
    if (tick === this.tick) return false;
    this.tick = tick;
    const { gl } = this.gpu;
    const { at, program } = this.pass;
    this.#choose(tick);
    let starved = false, complete = this.active.length > 0, foamy = true;
    gl.useProgram(program);
    gl.disable(gl.DEPTH_TEST);
    gl.viewport(0, 0, this.size, this.size);
    for (const cascade of this.active) {
      const { until_tick: until } = this.cascades[cascade];
      const rests = until !== null && tick >= until - REST_TICKS; // its last frames are nothing
      this.slots.fill(0);
      this.weights.fill(0);
      this.coarser.fill(1);
      for (let group = 0; group < DRAWN.length; group++) {
        const unit = this.#unit(cascade, group, tick);
        if (!unit) {
          if (group !== 3) complete = false;
          continue;
        }
        this.coarser[group] = this.size / unit.size;
        const pick = unit.seek(tick);
        if (pick.points === 0) {
          if (group === 3) foamy = false; else complete = false;
          continue;
        }
        starved ||= pick.starved && !rests;
        for (let i = 0; i < 4; i++) {
          this.slots[group * 4 + i] = pick.slots[i];
          for (let c = 0; c < unit.channels; c++) {
            this.weights[(FIRST_CHANNEL[group] + c) * 4 + i] = pick.weights[i] * unit.step(pick.slots[i], c);
          }
        }
      }
      gl.uniform4iv(at.uSlots, this.slots);
      gl.uniform4fv(at.uWeights, this.weights);
      gl.uniform4iv(at.uCoarser, this.coarser);
      const step = SMEAR_WAVES * this.longest[cascade] / this.patches[cascade] * this.size;
      gl.uniform2f(at.uSmear, crestwise[0] * step, crestwise[1] * step);
      [at.uDisplacement, at.uSlopes, at.uDerivatives, at.uFoam].forEach((location, group) => {
        bindTexture(gl, group, gl.TEXTURE_2D_ARRAY, (this.units[cascade][group] ?? this.empty).texture, location);
      });
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.targets[cascade]);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.activeTexture(gl.TEXTURE0);
    for (const texture of [this.displacement, this.gradient, this.moment, this.shear]) {
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
    }
    this.complete ||= complete;
    this.foamy = complete && foamy;
    return starved;
  }

  /** The unit to show; one of another level takes over once its frames reach back to the moment. */
  #unit(layer, group, tick) {
    const unit = this.units[layer][group], next = this.coming[layer][group];
    if (!next || !(next.ring.reaches(tick) || unit.ring.newest < 0)) return unit;
    unit.dispose();
    this.coming[layer][group] = null;
    this.units[layer][group] = next;
    return next;
  }

  /** Uploads a few frames before they are needed, so that no single drawing pays for all. */
  uploadAhead(tick, most) {
    this.gpu.gl.activeTexture(this.gpu.gl.TEXTURE0);
    const all = this.all();
    for (let i = 0; i < all.length && most > 0; i++) {
      const unit = all[this.nextAhead++ % all.length];
      if (unit.uploadAhead(tick)) most--;
    }
  }

  /** Ticks of frames held ahead of a time by the unit that has the fewest; foam may not be warm yet. */
  ahead(tick) {
    let least = Infinity;
    for (const layer of this.active) {
      if (this.cascades[layer].until_tick !== null) continue;
      this.units[layer].forEach((unit, group) => {
        const newest = Math.max(unit?.ring.newest ?? -1, this.coming[layer][group]?.ring.newest ?? -1);
        if (newest >= 0) least = Math.min(least, newest - tick);
      });
    }
    return Number.isFinite(least) ? least : 0;
  }

  dispose() {
    const { gl } = this.gpu;
    for (const unit of [...this.all(), this.empty]) unit.dispose();
    for (const t of [this.displacement, this.gradient, this.moment, this.shear]) gl.deleteTexture(t);
    for (const f of this.targets) gl.deleteFramebuffer(f);
    gl.deleteProgram(this.pass.program);
  }

  #target(format, anisotropic) {
    const { gl, anisotropy, anisotropyName } = this.gpu;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, Math.log2(this.size) + 1, format, this.size, this.size, this.count);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    if (anisotropic && anisotropyName) gl.texParameterf(gl.TEXTURE_2D_ARRAY, anisotropyName, anisotropy);
    return texture;
  }
}
