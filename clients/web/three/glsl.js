// Shaders of the sea and its sky in three.js: waves displaced in the vertex shader, light in the fragment shader.
//
// What the pixel can't resolve becomes roughness: E[s s^T] - E[s] E[s]^T, both filtered, is the variance of the slopes
// below it. Fresnel term and glitter are those of such a surface (Bruneton, Neyret & Holzschuch 2010).

/** MOST cascades; rings of CELLS; flat from WAVES metres on, almost. */
export const SEA_VERTEX = `
#include <common>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
uniform sampler2DArray uDisplacement;
uniform int uCount;         // of cascades that are part of the sea
uniform float uLayer[MOST]; // where they lie in the textures
uniform float uLongest[MOST]; // wave, metres
uniform vec4 uPatch[MOST];  // place in the texture (u, v) of the mesh's origin, 1 / side, samples / side
uniform vec2 uEye;          // x, z of the camera from the mesh's origin
varying vec2 vRest;         // the undisplaced point, from there, too
varying vec3 vFromEye;
varying float vHeight;

void main() {
  // Odd vertices move onto their even neighbours towards the outer edge of a ring, which has become the next one there.
  float cell = position.y, reach = 0.5 * CELLS * cell;
  vec2 p = floor(uEye / (2.0 * cell)) * 2.0 * cell + position.xz * cell - reach, off = abs(p - uEye) / reach;
  float morph = clamp((max(off.x, off.y) - 0.6) / (0.4 - 8.0 / CELLS), 0.0, 1.0);
  p -= mod(position.xz, 2.0) * cell * morph;
  cell *= 1.0 + morph;
  float rough = 1.0 - smoothstep(0.5 * WAVES, 0.8 * WAVES, max(off.x, off.y) * reach);
  vec3 d = vec3(0.0);
  for (int i = 0; i < uCount; i++) {
    float keep = rough * smoothstep(3.0 * cell, 6.0 * cell, uLongest[i]); // a wave needs three cells
    if (keep == 0.0) continue;
    float lod = log2(max(1.0, 1.5 * cell * uPatch[i].w));
    d += keep * textureLod(uDisplacement, vec3(p * uPatch[i].z + uPatch[i].xy, uLayer[i]), lod).xyz;
  }
  vec4 mvPosition = modelViewMatrix * vec4(p.x + d.x, d.y, p.y + d.z, 1.0);
  vRest = p;
  vHeight = d.y;
  vFromEye = mvPosition.xyz * mat3(viewMatrix); // inverse of a turn
  gl_Position = projectionMatrix * mvPosition;
  #include <logdepthbuf_vertex>
  #include <fog_vertex>
}`;

const SKY = `
#include <common>
uniform vec3 uSun, uSunColor, uHorizon, uZenith;

/** Radiance of the sky without the sun's disc. */
vec3 skyAt(vec3 d) {
  float s = max(dot(d, uSun), 0.0);
  vec3 blue = mix(uHorizon, uZenith, 1.0 - exp(-3.2 * max(d.y, 0.0)));
  return blue + uSunColor * (0.012 * pow(s, 6.0) + 0.03 * pow(s, 60.0));
}`;

export const SEA_FRAGMENT = `
${SKY}
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
uniform sampler2DArray uGradient, uMoment, uShear;
uniform int uCount;
uniform float uLayer[MOST], uHs, uSlopes, uHaze; // height of waves; mean square slope of the whole sea; 1 / metres
uniform vec4 uPatch[MOST];
uniform vec3 uWater;        // what the body of the water gives back of the light
varying vec2 vRest;
varying vec3 vFromEye;
varying float vHeight;

float noise(vec2 p) {
  vec2 i = floor(p), f = p - i;
  f *= f * (3.0 - 2.0 * f);
  return mix(mix(rand(mod(i, 256.0)), rand(mod(i + vec2(1, 0), 256.0)), f.x),
             mix(rand(mod(i + vec2(0, 1), 256.0)), rand(mod(i + 1.0, 256.0)), f.x), f.y);
}

/** Share of a normal distribution below a value. */
float tail(float x) {
  return 1.0 / (1.0 + exp(-1.702 * x));
}

void main() {
  #include <logdepthbuf_fragment>
  float away = length(vFromEye), clear = 1.0, resolved = 0.0;
  vec3 view = -vFromEye / away, pull = vec3(0.0), variance = vec3(0.0);
  vec2 dx = dFdx(vRest), dy = dFdy(vRest), slope = vec2(0.0);
  for (int i = 0; i < uCount; i++) {
    float each = uPatch[i].z; // patches per metre
    vec3 at = vec3(vRest * each + uPatch[i].xy, uLayer[i]);
    vec4 moment = textureLod(uMoment, vec3(0.5, 0.5, uLayer[i]), 20.0);
    resolved += moment.x + moment.y;
    float keep = 1.0 - smoothstep(9.0, 26.0, away * each); // it goes before its repetition can be counted
    if (keep > 0.0) {
      vec4 gradient = keep * textureGrad(uGradient, at, dx * each, dy * each);
      moment = mix(moment, textureGrad(uMoment, at, dx * each, dy * each), keep);
      slope += gradient.xy;
      pull += vec3(gradient.zw, keep * textureGrad(uShear, at, dx * each, dy * each).r);
      variance -= vec3(gradient.xy * gradient.xy, gradient.x * gradient.y);
    }
    variance += moment.xyz;
    clear *= 1.0 - moment.w;
  }
  // What a pixel can't resolve is roughness, and so is what lies below the cascades.
  variance.xy = max(variance.xy, 0.0) + 0.5 * max(uSlopes - resolved, 0.002);
  float most = 0.9 * sqrt(variance.x * variance.y);
  variance.z = clamp(variance.z, -most, most);

  // The exact normal of the displaced surface; where it folds, that of a very steep face.
  vec2 stretch = 1.0 + pull.xy;
  vec3 normal = normalize(vec3(slope.y * pull.z - slope.x * stretch.y,
    max(stretch.x * stretch.y - pull.z * pull.z, 0.08), slope.x * pull.z - slope.y * stretch.x));
  float facing = dot(normal, view);
  normal = normalize(normal + view * max(0.02 - facing, 0.0));
  facing = max(facing, 0.02);

  // The sky in it, by facets that lean towards the eye. Rays that go down meet other water.
  vec2 along = view.xz / max(length(view.xz), 1e-4), lean = -normal.xz / max(normal.y, 0.05);
  float sigma2 = dot(variance.xyz, vec3(along * along, 2.0 * along.x * along.y)), sigma = sqrt(sigma2);
  float tangent = (view.y - dot(lean, view.xz)) / max(length(view.xz), 1e-3), t = tangent / sigma;
  float bell = 0.39894 * exp(-0.5 * t * t);
  vec2 seen = lean - along * min(sigma2 * tail(t) / max(tangent * tail(t) + sigma * bell, 1e-4), 1.5 * sigma);
  vec3 up = reflect(-view, normalize(vec3(-seen.x, 1.0, -seen.y)));
  float open = smoothstep(-0.25, 0.1, up.y);
  float fresnel = 0.02 + 0.98 * pow(1.0 - facing, 5.0 * exp(-2.69 * sigma)) / (1.0 + 22.7 * pow(sigma, 1.5));
  vec3 sky = skyAt(normalize(vec3(up.x, max(up.y, 0.02), up.z)));

  // The sun in it: as many facets as lean so that they mirror it.
  vec3 halfway = normalize(view + uSun);
  vec2 off = -halfway.xz / halfway.y - lean;
  float det = max(variance.x * variance.y - variance.z * variance.z, 1e-9), h2 = halfway.y * halfway.y;
  float power = 0.5 * (variance.y * off.x * off.x - 2.0 * variance.z * off.x * off.y + variance.x * off.y * off.y) / det;
  float glint = (0.02 + 0.98 * pow(1.0 - max(dot(view, halfway), 0.0), 5.0)) * exp(-min(power, 80.0))
    / (PI2 * sqrt(det) * 4.0 * h2 * h2 * max(facing / normal.y, 0.1) * (1.0 + 4.0 * exp(-4.0 * max(t, 0.0))));
  glint = min(glint, 20.0) * smoothstep(-0.1, 0.15, dot(normal, uSun));

  // The body of the water, and light through crests that stand against it.
  vec3 daylight = 0.5 * (uHorizon + uZenith) + uSunColor * max(uSun.y, 0.0) / PI;
  float crest = clamp(2.0 * vHeight / uHs, 0.0, 1.5), against = pow(max(dot(view, -uSun), 0.0), 3.0);
  vec3 body = uWater * daylight * (1.0 + crest * (0.5 * (1.0 - normal.y) + vec3(0.6, 1.6, 1.2) * against));
  vec3 color = mix(body, sky, fresnel * open) + fresnel * (1.0 - open) * body + uSunColor * glint;

  // Foam: a lace whose share is what the channel says.
  float foam = 1.0 - clear, footprint = length(fwidth(vRest));
  float large = noise(vRest * 0.5);
  vec2 bent = vRest + 1.3 * large; // hides the grid of the noise
  float lace = tail((0.5 * large + 0.3 * noise(bent * 2.0) + 0.2 * noise(bent * 8.0) - 0.5) / 0.13); // even, 0 to 1
  float veil = foam * 6.0 * pow(1.0 - lace, 5.0), holes = 1.0 - (1.0 - foam) * 6.0 * pow(lace, 5.0);
  float white = mix(clamp(mix(veil, holes, smoothstep(0.1, 0.9, foam)), 0.0, 1.0), foam, smoothstep(0.1, 1.5, footprint));
  color = mix(color, 0.85 * (0.5 * (uHorizon + uZenith) + uSunColor * max(0.2, dot(normal, uSun)) / PI), 0.95 * white);

  color = mix(color, skyAt(normalize(vec3(vFromEye.x, 0.01 * away, vFromEye.z))), 1.0 - exp(-away * uHaze));
  gl_FragColor = vec4(color, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
  #include <fog_fragment>
}`;

export const SKY_VERTEX = `
varying vec3 vAway;
void main() {
  vAway = position;
  gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
  gl_Position.z = 0.0; // whatever the near plane is
}`;

export const SKY_FRAGMENT = `
${SKY}
varying vec3 vAway;
void main() {
  vec3 away = normalize(vAway);
  float off = acos(clamp(dot(away, uSun), -1.0, 1.0)); // the disc is half a degree wide
  vec3 disc = uSunColor * (20.0 * smoothstep(0.0056, 0.0044, off) + 0.25 * exp(-off * 22.0)) * step(0.0, away.y);
  gl_FragColor = vec4(skyAt(away) + disc, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;
