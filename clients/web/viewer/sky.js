// The sky: a clear atmosphere, its light at the water, and a small map of it for reflections.
//
// Single scattering by air and haze along flat-layer paths (Hoffman & Preetham 2002) with air mass
// after Kasten & Young 1989, plus an even term for light scattered more than once. Radiance is in
// units in which the sun above the air gives an irradiance of SUN.

import { COVER_VERTEX, makeProgram } from '../src/gl.js';

const WIDTH = 256, HEIGHT = 128;

/** Shared by every shader that looks at the sky. `uSun` points to the sun. */
export const SKY_GLSL = `
const float PI = 3.14159265;
const vec3 SUN = vec3(18.6, 19.8, 23.6); // white balance: a low sun is a little warm, not orange
const vec3 AIR = vec3(0.049, 0.113, 0.278);  // optical depth of air, straight up, at 680, 550, 440 nm
const vec3 DUST = vec3(0.036, 0.039, 0.043); // of haze
uniform vec3 uSun;

float airMass(float sinElevation) {
  float s = max(sinElevation, 0.0);
  return 1.0 / (s + 0.50572 * pow(6.07995 + degrees(asin(min(s, 1.0))), -1.6364));
}

/** Sun's irradiance on a surface that faces it. */
vec3 sunIrradiance() {
  return SUN * exp(-(AIR + DUST) * airMass(uSun.y));
}

/** Radiance of the sky, without the disc of the sun. */
vec3 skyRadiance(vec3 d) {
  float c = dot(d, uSun);
  float air = 3.0 / (16.0 * PI) * (1.0 + c * c);
  const float g = 0.76, g2 = 0.92;
  float haze = (1.0 - g * g) / (4.0 * PI * pow(1.0 + g * g - 2.0 * g * c, 1.5));
  float glow = (1.0 - g2 * g2) / (4.0 * PI * pow(1.0 + g2 * g2 - 2.0 * g2 * c, 1.5));
  vec3 depth = AIR + DUST;
  vec3 once = (AIR * air + DUST * mix(haze, glow, 0.12)) / depth;
  vec3 often = (AIR + 0.8 * DUST) / depth * 0.030;
  vec3 reach = exp(-depth * airMass(uSun.y) * 0.35);
  return SUN * (once * reach + often * sqrt(reach)) * (1.0 - exp(-depth * airMass(d.y)));
}

/**
 * Display value of a radiance, with a white balance that goes some of the way to the sun's. Luminance
 * follows a curve that is linear in the dark and closes in on white as slowly as film does, so that
 * glitter a hundred times brighter than the sea keeps its shape. Hue stays; what the display can't
 * show as bright in that colour goes towards white, no further.
 */
vec3 develop(vec3 radiance, float exposure) {
  vec3 white = sunIrradiance();
  white /= dot(white, vec3(0.2126, 0.7152, 0.0722));
  vec3 c = radiance * exposure * pow(white, vec3(-0.22));
  float l = max(dot(c, vec3(0.2126, 0.7152, 0.0722)), 1e-6);
  float shown = 1.0 - pow(1.0 + l / 0.58, -0.61);
  c *= shown / l;
  float reach = max(max(c.r, max(c.g, c.b)) - shown, 0.0) / (1.0 - shown); // 1: as far from grey as can be shown
  c = shown + (c - shown) * pow(1.0 + reach * reach * reach, -0.3333);
  return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2));
}

/** Where a direction lies in the map of the sky: finer towards the horizon. */
vec2 skyMapAt(vec3 d) {
  float elevation = asin(clamp(d.y, 0.0, 1.0));
  return vec2(atan(d.z, d.x) / (2.0 * PI), sqrt(elevation / (0.5 * PI)));
}
`;

const MAP = `
in vec2 vCover;
out vec4 oColor;
${SKY_GLSL}
void main() {
  vec2 uv = vCover * 0.5 + 0.5;
  float azimuth = uv.x * 2.0 * PI, elevation = uv.y * uv.y * 0.5 * PI;
  oColor = vec4(skyRadiance(vec3(cos(elevation) * cos(azimuth), sin(elevation), cos(elevation) * sin(azimuth))), 1.0);
}`;

export class SkyMap {
  /** @param {import('../src/gl.js').Gpu} gpu */
  constructor(gpu) {
    const { gl } = gpu;
    this.gl = gl;
    this.pass = makeProgram(gl, 'sky map', COVER_VERTEX, MAP);
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texStorage2D(gl.TEXTURE_2D, Math.log2(WIDTH) + 1, gl.RGBA16F, WIDTH, HEIGHT);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    this.target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** @param {Float32Array} sun unit vector towards it */
  draw(sun) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.viewport(0, 0, WIDTH, HEIGHT);
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(this.pass.program);
    gl.uniform3fv(this.pass.at.uSun, sun);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.generateMipmap(gl.TEXTURE_2D);
  }
}
