// One eye's view of the world: where it is, what it sees, and how that becomes clip space.

export class View {
  constructor() {
    this.eye = [0, 0, 0];
    /** x, y, width, height in the framebuffer. */
    this.viewport = [0, 0, 1, 1];
    /** Clip space from positions relative to the eye; the far plane lies at infinity. */
    this.clip = new Float32Array(16);
    /** World from camera. */
    this.turn = new Float32Array(9);
    /** Tangents at the view's middle and of half its width and height: x, y, half width, half height. */
    this.lens = new Float32Array(4);
    this.planes = Array.from({ length: 5 }, () => new Float64Array(3));
    this.sees = (/** @type {number[]} */ box) => this.planes.every((p) => reaches(p, box));
  }

  /**
   * @param {number[]} eye world position, metres
   * @param {{right: number[], up: number[], forward: number[], near: number}} axes unit vectors, metres
   * @param {number[]} tangents of the view's left, right, lower and upper edge
   */
  look(eye, { right, up, forward, near }, [left, rightmost, lower, upper]) {
    const { clip, turn, planes, lens } = this;
    const width = rightmost - left, height = upper - lower;
    for (let i = 0; i < 3; i++) {
      this.eye[i] = eye[i];
      clip[i * 4] = (2 * right[i] - (rightmost + left) * forward[i]) / width;
      clip[i * 4 + 1] = (2 * up[i] - (upper + lower) * forward[i]) / height;
      clip[i * 4 + 2] = forward[i];
      clip[i * 4 + 3] = forward[i];
      turn[i] = right[i];
      turn[3 + i] = up[i];
      turn[6 + i] = -forward[i];
      planes[0][i] = forward[i];
      planes[1][i] = right[i] - left * forward[i];
      planes[2][i] = rightmost * forward[i] - right[i];
      planes[3][i] = up[i] - lower * forward[i];
      planes[4][i] = upper * forward[i] - up[i];
    }
    clip[14] = -2 * near;
    lens.set([(left + rightmost) / 2, (lower + upper) / 2, width / 2, height / 2]);
  }
}

/** Whether some point of a box lies on the inner side of a plane through the eye. */
function reaches(p, box) {
  return p[0] * box[p[0] > 0 ? 3 : 0] + p[1] * box[p[1] > 0 ? 4 : 1] + p[2] * box[p[2] > 0 ? 5 : 2] >= 0;
}
