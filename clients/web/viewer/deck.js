// A boat that floats: where its deck is follows from the water's heights below the hull at the same moment alone, so
// everybody who boards it is moved alike.

/** Length, width, and how far the deck is above the mean water below it, metres. */
export const LENGTH_M = 9, WIDTH_M = 3.6, FREEBOARD_M = 0.9;
const ALONG = 7, ACROSS = 3; // places below the hull at which the water is asked for
const STEEPEST = 0.6; // tangent

export class Deck {
  constructor() {
    /** Middle of the deck, metres, and the way the bow points, degrees clockwise from north. */
    this.x = 0;
    this.z = 0;
    this.heading = 0;
    this.y = 0;
    /** How the deck rises towards the bow and to starboard, tangents. */
    this.pitch = 0;
    this.roll = 0;
  }

  /** Goes elsewhere. */
  moor(x, z, heading) {
    Object.assign(this, { x, z, heading });
  }

  /** Unit vectors in the horizontal plane: x, z of the bow's and of starboard's. */
  axes() {
    const a = this.heading * Math.PI / 180, sin = Math.sin(a), cos = Math.cos(a);
    return { bow: [sin, -cos], starboard: [cos, sin] };
  }

  /**
   * The plane through the heights below the hull, by least squares.
   * @param {(x: number, z: number) => number} heightAt metres
   */
  float(heightAt) {
    const { bow, starboard } = this.axes();
    let sum = 0, rise = 0, lean = 0, along2 = 0, across2 = 0;
    for (let i = 0; i < ALONG; i++) {
      const along = (i / (ALONG - 1) - 0.5) * LENGTH_M;
      for (let j = 0; j < ACROSS; j++) {
        const across = (j / (ACROSS - 1) - 0.5) * WIDTH_M;
        const height = heightAt(this.x + along * bow[0] + across * starboard[0], this.z + along * bow[1] + across * starboard[1]);
        sum += height;
        rise += along * height;
        lean += across * height;
        along2 += along * along;
        across2 += across * across;
      }
    }
    const bounded = (tangent) => Math.max(-STEEPEST, Math.min(STEEPEST, tangent));
    this.y = sum / (ALONG * ACROSS) + FREEBOARD_M;
    this.pitch = bounded(rise / along2);
    this.roll = bounded(lean / across2);
  }

  /** Where a place is on the deck, metres towards the bow and to starboard. */
  local(x, z) {
    const { bow, starboard } = this.axes(), dx = x - this.x, dz = z - this.z;
    return [dx * bow[0] + dz * bow[1], dx * starboard[0] + dz * starboard[1]];
  }

  /** @returns {number | null} the deck's height at a place; null beside it */
  heightAt(x, z) {
    const [along, across] = this.local(x, z);
    if (Math.abs(along) > LENGTH_M / 2 || Math.abs(across) > WIDTH_M / 2) return null;
    return this.y + this.pitch * along + this.roll * across;
  }

  /** Columns that take metres to starboard, up from the deck and towards the bow to the world. */
  matrix() {
    const { bow, starboard } = this.axes();
    return new Float32Array([
      starboard[0], this.roll, starboard[1], 0, -this.roll * starboard[0] - this.pitch * bow[0], 1, -this.roll * starboard[1] - this.pitch * bow[1], 0,
      bow[0], this.pitch, bow[1], 0, this.x, this.y, this.z, 1,
    ]);
  }
}
