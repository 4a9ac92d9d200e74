// The water's shaders: waves displaced in the vertex shader, light in the fragment shader.
//
// What the pixel can't resolve becomes roughness: slopes and their second moments are filtered
// together (Olano & Baker 2010), so E[s s^T] - E[s] E[s]^T is the variance of the slopes below the
// pixel. Light on such a surface follows Bruneton, Neyret & Holzschuch 2010: mean Fresnel term and
// sun glitter from the distribution of slopes (Ross, Dion & Potvin 2005).

import { SKY_GLSL } from './sky.js';

/** Uniforms of both shaders. MOST is the largest number of cascades. */
const SHARED = `
precision highp sampler2DArray;
uniform int uCount;         // of cascades that are part of the sea
uniform float uLayer[MOST]; // where they lie in the textures
uniform vec4 uPatch[MOST];  // offset in the texture (u, v) of the grid's origin, 1 / side, samples / side
uniform vec3 uEye;          // relative to the grid's origin; y above the rest surface
`;

export const WATER_VERTEX = `
${SHARED}
layout(location = 0) in vec2 aIndex;
uniform vec4 uRing;  // corner x, z; cell; least morph
uniform vec2 uMorph; // start, 1 / range
uniform vec2 uCalm;  // where waves begin to be drawn flat, and are
uniform mat4 uView;  // clip from eye-relative
uniform sampler2DArray uDisplacement;
uniform float uLongest[MOST]; // wave of the cascade, metres
out vec2 vRest;      // the undisplaced point, relative to the grid's origin
out vec3 vFromEye;
out float vHeight;

void main() {
  vec2 p = uRing.xy + aIndex * uRing.z;
  vec2 away = abs(p - uEye.xz);
  float morph = clamp((max(away.x, away.y) - uMorph.x) * uMorph.y, uRing.w, 1.0);
  p -= mod(aIndex, 2.0) * uRing.z * morph;

  // A wave needs three cells: shorter ones are filtered away, a cascade that has only such is left out.
  float cell = uRing.z * (1.0 + morph);
  float rough = 1.0 - smoothstep(uCalm.x, uCalm.y, max(away.x, away.y));
  vec3 d = vec3(0.0);
  for (int i = 0; i < uCount; i++) {
    float keep = rough * smoothstep(3.0 * cell, 6.0 * cell, uLongest[i]);
    if (keep == 0.0) continue;
    float lod = log2(max(1.0, 1.5 * cell * uPatch[i].w));
    d += keep * textureLod(uDisplacement, vec3(p * uPatch[i].z + uPatch[i].xy, uLayer[i]), lod).xyz;
  }
  vRest = p;
  vHeight = d.y;
  vFromEye = vec3(p.x - uEye.x + d.x, d.y - uEye.y, p.y - uEye.z + d.z);
  gl_Position = uView * vec4(vFromEye, 1.0);
}`;

export const WATER_FRAGMENT = `
${SHARED}
${SKY_GLSL}
in vec2 vRest;
in vec3 vFromEye;
in float vHeight;
uniform sampler2DArray uGradient, uMoment, uShear;
uniform vec2 uMeanSquareSlope; // of the whole sea, and least of what is below the cascades
uniform sampler2D uSky, uFoamPattern;
uniform vec2 uFade;      // patches away at which a cascade starts to go, and is gone
uniform int uFinest;     // the cascade of the shortest waves
uniform float uRipples;  // share of the slopes below the cascades that is drawn as ripples
uniform float uCrest;    // height of a high crest, metres
uniform vec2 uCrestwise; // unit vector along the crests, or zero
uniform float uExposure;
uniform float uHaze;     // 1 / metres
out vec4 oColor;

const vec3 DEEP = vec3(0.0022, 0.0125, 0.0250);   // reflectance of the water body
const vec3 THIN = vec3(0.0060, 0.0700, 0.0680);   // of thin crests against the light

float normalTail(float x) { // integral of the normal distribution up to x
  return 1.0 / (1.0 + exp(-1.702 * x));
}

/** Smith's shadowing of a rough sea at a tangent of elevation, in standard deviations. */
float shadow(float t) {
  return t > 1.6 ? 0.0 : (1.0 - 1.259 * t + 0.396 * t * t) / (3.535 * t + 2.181 * t * t);
}

/** A number between 0 and 1, even and unrelated for every whole number. */
float dice(vec3 p) {
  uvec3 q = uvec3(ivec3(floor(p))) * uvec3(1597334673u, 3812015801u, 2798796415u);
  uint n = (q.x ^ q.y ^ q.z) * 1597334673u;
  n = (n ^ (n >> 15)) * 2246822519u;
  return (float(n >> 8) + 0.5) / 16777216.0;
}

/** Foam's threshold, smeared along a step to either side. */
float pattern(vec2 at, vec2 along) {
  return (texture(uFoamPattern, at - along).r + texture(uFoamPattern, at).r + texture(uFoamPattern, at + along).r) / 3.0;
}

void main() {
  float distance = length(vFromEye);
  vec3 view = -vFromEye / distance;

  // Sums over cascades.
  vec2 slope = vec2(0.0);
  vec3 derivative = vec3(0.0); // Dxx, Dzz, Dxz
  vec3 variance = vec3(0.0);   // of slopes: xx, zz, xz
  float clear = 1.0;           // of foam
  float resolved = 0.0;        // mean square slope of all cascades
  vec2 dx = dFdx(vRest), dy = dFdy(vRest);
  for (int i = 0; i < uCount; i++) {
    float each = uPatch[i].z; // patches per metre
    vec3 at = vec3(vRest * each + uPatch[i].xy, uLayer[i]);
    float keep = 1.0 - smoothstep(uFade.x, uFade.y, distance * each);
    vec4 moment = textureLod(uMoment, vec3(0.5, 0.5, uLayer[i]), 20.0);
    resolved += moment.x + moment.y;
    if (keep > 0.0) {
      vec4 gradient = keep * textureGrad(uGradient, at, dx * each, dy * each);
      moment = mix(moment, textureGrad(uMoment, at, dx * each, dy * each), keep);
      slope += gradient.xy;
      derivative += vec3(gradient.zw, keep * textureGrad(uShear, at, dx * each, dy * each).r);
      variance -= vec3(gradient.xy * gradient.xy, gradient.x * gradient.y);
    }
    variance += moment.xyz;
    clear *= 1.0 - moment.w;
  }
  float foam = 1.0 - clear;

  // Below the shortest streamed wave the spectrum goes on, and its slopes look alike at every scale:
  // the finest cascade, smaller and turned, stands in for a share of it. The rest is roughness.
  float below = max(uMeanSquareSlope.x - resolved, uMeanSquareSlope.y);
  vec4 finest = uPatch[uFinest];
  float each = finest.z * 6.7;
  float keep = uRipples > 0.0 ? 1.0 - smoothstep(uFade.x, uFade.y, distance * each) : 0.0;
  if (keep > 0.0) {
    const mat2 TURN = mat2(0.8, 0.6, -0.6, 0.8);
    vec4 mean = textureLod(uMoment, vec3(0.5, 0.5, uLayer[uFinest]), 20.0);
    float gain2 = min(uRipples * below / max(mean.x + mean.y, 1e-5), 1.5);
    vec3 at = vec3(TURN * vRest * each + finest.xy * 6.7, uLayer[uFinest]);
    mat2 grad = TURN * mat2(dx, dy) * each;
    vec2 ripple = keep * sqrt(gain2) * (textureGrad(uGradient, at, grad[0], grad[1]).xy * TURN);
    vec4 moment = mix(mean, textureGrad(uMoment, at, grad[0], grad[1]), keep);
    below -= gain2 * (mean.x + mean.y);
    slope += ripple;
    variance += vec3(max(vec2(0.0), 0.5 * gain2 * (moment.x + moment.y) - ripple * ripple), 0.0);
  }
  variance.xy = max(variance.xy, 0.0) + 0.5 * max(below, 0.0) + 2e-4;
  float most = 0.9 * sqrt(variance.x * variance.y);
  variance.z = clamp(variance.z, -most, most);

  // Exact normal of the displaced surface; where it folds, that of a very steep face.
  vec2 stretch = 1.0 + derivative.xy;
  vec3 normal = vec3(-(slope.x * stretch.y - slope.y * derivative.z),
                     max(stretch.x * stretch.y - derivative.z * derivative.z, 0.08),
                     -(slope.y * stretch.x - slope.x * derivative.z));
  normal = normalize(normal);
  float facing = dot(normal, view);
  if (facing < 0.02) normal = normalize(normal + view * (0.02 - facing));
  facing = max(dot(normal, view), 0.02);

  // Facets that are seen lean towards the eye: their mean slope along the view.
  vec2 along = view.xz / max(length(view.xz), 1e-4);
  float sigma2 = dot(along, vec2(variance.x * along.x + variance.z * along.y, variance.z * along.x + variance.y * along.y));
  float sigma = sqrt(max(sigma2, 1e-5));
  vec2 meanSlope = -normal.xz / max(normal.y, 0.05);
  float tangent = (view.y - dot(meanSlope, view.xz)) / max(length(view.xz), 1e-3);
  float t = tangent / sigma;
  float bell = 0.39894 * exp(-0.5 * t * t), tail = normalTail(t);
  float lean = sigma2 * tail / max(tangent * tail + sigma * bell, 1e-4);
  vec2 seenSlope = meanSlope - along * min(lean, 1.5 * sigma);
  vec3 seen = normalize(vec3(-seenSlope.x, 1.0, -seenSlope.y));

  // Mean Fresnel reflectance.
  float fresnel = 0.02 + 0.98 * pow(1.0 - facing, 5.0 * exp(-2.69 * sigma)) / (1.0 + 22.7 * pow(sigma, 1.5));

  // The sky in it. Rays that go down meet other water.
  vec3 up = reflect(-view, seen);
  float open = smoothstep(-0.25, 0.1, up.y);
  up.y = max(up.y, 0.015);
  vec3 sky = textureLod(uSky, skyMapAt(normalize(up)), log2(1.0 + 60.0 * sigma)).rgb;
  vec3 skyMean = textureLod(uSky, vec2(0.5, 0.6), 20.0).rgb;

  // The sun in it.
  vec3 sun = sunIrradiance();
  vec3 halfway = normalize(view + uSun);
  vec2 off = -halfway.xz / halfway.y - meanSlope;
  vec3 spot = variance + vec3(2e-5, 2e-5, 0.0);
  float spotDet = max(spot.x * spot.y - spot.z * spot.z, 1e-9);
  float power = 0.5 * (spot.y * off.x * off.x - 2.0 * spot.z * off.x * off.y + spot.x * off.y * off.y) / spotDet;
  float density = exp(-min(power, 80.0)) / (2.0 * PI * sqrt(spotDet));
  float h2 = halfway.y * halfway.y;
  float glint = (0.02 + 0.98 * pow(1.0 - max(dot(view, halfway), 0.0), 5.0)) * density
    / (4.0 * h2 * h2 * max(facing / normal.y, 0.02) * (1.0 + shadow(max(t, 0.02)) + shadow(uSun.y / (sigma * sqrt(1.0 - uSun.y * uSun.y)))));
  // Few of the facets below a pixel mirror the sun at once: their number scatters, so glitter sparkles.
  float scatter = 0.8 * smoothstep(0.08, 0.6, max(length(dx), length(dy)))
    * inversesqrt(1.0 + 60.0 * glint * abs(dx.x * dy.y - dx.y * dy.x));
  glint *= mix(1.0, -log(dice(vec3(gl_FragCoord.xy, 30.0 * (slope.x + slope.y)))), scatter);
  float lit = smoothstep(-0.1, 0.15, dot(normal, uSun));

  // The body of the water, and light through thin crests.
  vec3 daylight = skyMean * PI * 0.8 + sun * uSun.y;
  float crest = clamp(vHeight / uCrest, 0.0, 1.4);
  float against = pow(max(dot(view, -normalize(vec3(uSun.x, 0.0, uSun.z))), 0.0), 3.0);
  float steep = clamp(1.0 - normal.y, 0.0, 0.5) * 2.0;
  vec3 body = DEEP * daylight / PI * 2.2;
  body += THIN * daylight / PI * (crest * against * (0.25 + steep) * 0.9 + 0.10 * crest * steep + 0.25 * foam);

  vec3 color = mix(body, sky, fresnel * open) + fresnel * (1.0 - open) * body + sun * min(glint, 60.0) * lit;

  // Foam: a lace whose mean is what the channel says. Thin foam is a veil with few bright rafts, dense
  // foam is white with few holes. Both are drawn out along the crests.
  float footprint = length(fwidth(vRest));
  float t0 = pattern(vRest / 6.1, uCrestwise * 0.9 / 6.1);
  float t1 = pattern(vRest.yx / 1.9 + 0.37, uCrestwise.yx * 0.28 / 1.9);
  float bubbles = texture(uFoamPattern, vRest / 0.43).r;
  float threshold = normalTail((0.50 * t0 + 0.34 * t1 + 0.16 * bubbles - 0.5) / 0.114); // even, 0 to 1
  float veil = foam * 6.0 * pow(1.0 - threshold, 5.0);
  float holes = 1.0 - (1.0 - foam) * 6.0 * pow(threshold, 5.0);
  float blur = smoothstep(0.08, 1.2, footprint);
  float white = mix(clamp(mix(veil, holes, smoothstep(0.1, 0.9, foam)), 0.0, 1.0), foam, blur);
  float thick = mix(0.78, 1.0, smoothstep(0.0, 0.6, white)) * (1.0 - 0.25 * (1.0 - blur) * smoothstep(0.4, 0.9, bubbles));
  float wrapped = max(0.25, (dot(normal, uSun) + 0.35) / 1.35); // light wanders between bubbles
  vec3 foamLight = 0.9 * (skyMean * PI * 0.9 * (0.5 + 0.5 * normal.y) + sun * wrapped) / PI;
  color = mix(color, foamLight * thick, white * 0.94);

  // Air between.
  vec3 level = normalize(vec3(vFromEye.x, 0.012 * length(vFromEye.xz), vFromEye.z));
  float haze = 1.0 - exp(-distance * uHaze);
  color = mix(color, textureLod(uSky, skyMapAt(level), 0.0).rgb, haze);

  oColor = vec4(develop(color, uExposure), 1.0);
}`;

export const BACKGROUND_FRAGMENT = `
${SKY_GLSL}
in vec2 vCover;
uniform vec4 uLens;   // tangents at the view's middle: x, y, and of half its width and height
uniform mat3 uTurn;   // world from camera
uniform float uExposure;
out vec4 oColor;

void main() {
  vec3 d = normalize(uTurn * vec3(uLens.xy + vCover * uLens.zw, -1.0));
  vec3 color = skyRadiance(normalize(vec3(d.x, max(d.y, 0.012), d.z)));
  float off = acos(clamp(dot(d, uSun), -1.0, 1.0));
  color += sunIrradiance() * (400.0 * smoothstep(0.0056, 0.0044, off) + 0.25 * exp(-off * 22.0)) * step(0.0, d.y);
  float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  oColor = vec4(develop(color, uExposure) + grain / 255.0, 1.0);
}`;
