// What the page's address asks for. Defaults live only here.

const DEFAULTS = {
  rate: 15, // frames a second
  level: 0,
  class: '1mm',
  codec: 'rans', // or 'i16': counts as they are, ten times the bytes
  eye: [0, 6, 0], // metres; y above the rest surface
  look: [262, -5], // yaw clockwise from north, pitch up, degrees
  sun: [238, 13], // azimuth clockwise from north, elevation, degrees
  still: false, // no panel, no help
  ripples: true, // shading below the shortest streamed wave
  detail: 'high', // or 'low': half the mesh, no antialiasing, little anisotropic filtering
  adapt: true, // gives way in rate, level and mesh before pictures are dropped
  scale: 0, // drawing buffer pixels per CSS pixel; 0: the device's, at most 2
};

/**
 * @param {string} search the query part of the address
 * @returns {typeof DEFAULTS}
 */
export function readOptions(search) {
  const query = new URLSearchParams(search);
  const options = structuredClone(DEFAULTS);
  for (const [name, standard] of Object.entries(DEFAULTS)) {
    const given = query.get(name);
    if (given === null) continue;
    if (typeof standard === 'string') options[name] = given;
    else if (typeof standard === 'boolean') options[name] = given !== '0' && given !== 'false';
    else {
      const numbers = given.split(',').map(Number);
      const wanted = Array.isArray(standard) ? standard.length : 1;
      if (numbers.length !== wanted || !numbers.every(Number.isFinite)) continue;
      options[name] = Array.isArray(standard) ? numbers : numbers[0];
    }
  }
  return options;
}
