// In a headset: the session, where its wearer stands, both eyes' views, teleport. Draws nothing itself.
//
// The floor is the deck of a boat or the rest surface of the sea. The wearer is carried up and down with the deck and
// never tilted: the horizon stays level (roll and pitch of the view, not heave, are what makes people ill).

import { LENGTH_M, WIDTH_M } from './deck.js';
import { Lift } from './lift.js';
import { View } from './view.js';

const NEAR_M = 0.1;
const FARTHEST_M = 60; // of a teleport

/** Whether this browser can enter VR. */
export async function canEnter() {
  return Boolean(await navigator.xr?.isSessionSupported('immersive-vr').catch(() => false));
}

export class Immersion {
  /**
   * @param {XRSession} session
   * @param {XRReferenceSpace} space whose floor is the wearer's
   * @param {import('./deck.js').Deck} deck
   * @param {{eye: number[], yaw: number}} from where the page looks from
   * @param {string} floor 'deck' or 'sea'
   */
  constructor(session, space, deck, from, floor) {
    this.session = session;
    this.space = space;
    this.deck = deck;
    this.views = [new View(), new View()];
    this.lift = new Lift();
    this.yaw = from.yaw;
    /** Where the middle of the play space is, metres. */
    this.place = [from.eye[0], 0, from.eye[2]];
    this.head = [0, 0, 0]; // of the wearer, in the play space
    /** Where a teleport would lead, while a controller points. */
    this.target = null;
    this.pointing = null;
    deck.moor(from.eye[0], from.eye[2], from.yaw);
    this.floor = floor;
    session.addEventListener('selectstart', (e) => { this.pointing = e.inputSource; });
    session.addEventListener('selectend', (e) => {
      if (e.inputSource !== this.pointing) return; // another hand's
      if (this.target) this.#stand(this.target);
      this.pointing = this.target = null;
    });
    session.addEventListener('squeezestart', () => this.setFloor(this.floor === 'deck' ? 'sea' : 'deck'));
  }

  /**
   * Asks the browser for VR; only in answer to a press of a button.
   * @param {WebGL2RenderingContext} gl
   * @param {import('./deck.js').Deck} deck
   * @param {{eye: number[], yaw: number}} from
   * @param {string} floor
   */
  static async enter(gl, deck, from, floor) {
    const session = await navigator.xr.requestSession('immersive-vr', { requiredFeatures: ['local-floor'] });
    try {
      await gl.makeXRCompatible();
      await session.updateRenderState({ baseLayer: new XRWebGLLayer(session, gl, { alpha: false }), depthNear: NEAR_M });
      return new Immersion(session, await session.requestReferenceSpace('local-floor'), deck, from, floor);
    } catch (error) {
      await session.end().catch(() => {}); // else the wearer would be left in the dark
      throw error;
    }
  }

  /** To the deck, or overboard. */
  setFloor(floor) {
    this.floor = floor;
    if (floor === 'deck') this.#stand([this.deck.x, this.deck.z]);
  }

  /**
   * Sets the views to a picture. The deck floats already.
   * @param {XRFrame} frame
   * @param {number} seconds since the last
   * @param {(x: number, z: number) => number} water height, metres
   * @returns {View[]} of the eyes; none while the headset doesn't know where it is
   */
  look(frame, seconds, water) {
    const pose = frame.getViewerPose(this.space), layer = this.session.renderState.baseLayer;
    if (!pose) return [];
    const { x, y, z } = pose.transform.position;
    this.head = [x, y, z];
    const at = this.#world([x, y, z]);
    // Feet follow the floor where the wearer stands, not where the play space is centred.
    const deck = this.floor === 'deck' ? this.deck.heightAt(at[0], at[2]) ?? this.deck.y : 0;
    this.place[1] = deck;
    const eye = deck + y;
    this.place[1] += this.lift.above(eye, water(at[0], at[2]), seconds) - eye;
    this.#point(frame);
    return pose.views.map((seen, i) => {
      const view = this.views[i] ??= new View();
      const { position, matrix: m } = seen.transform, p = seen.projectionMatrix, port = layer.getViewport(seen);
      view.viewport = [port.x, port.y, port.width, port.height];
      view.look(this.#world([position.x, position.y, position.z]), {
        right: this.#turned([m[0], m[1], m[2]]), up: this.#turned([m[4], m[5], m[6]]), forward: this.#turned([-m[8], -m[9], -m[10]]), near: NEAR_M,
      }, [(p[8] - 1) / p[0], (p[8] + 1) / p[0], (p[9] - 1) / p[5], (p[9] + 1) / p[5]]);
      return view;
    });
  }

  /** Columns of a board that stands before the wearer, low, facing him. */
  boardMatrix() {
    const a = this.yaw * Math.PI / 180, sin = Math.sin(a), cos = Math.cos(a);
    const [x, y, z] = this.#world([0, 0.8, -1.1]);
    return new Float32Array([cos, 0, sin, 0, 0, 1, 0, 0, -sin, 0, cos, 0, x, y, z, 1]);
  }

  /**
   * Columns of the mark of a teleport; null while there is none.
   * @param {(x: number, z: number) => number} water height, metres
   */
  markMatrix(water) {
    if (!this.target) return null;
    const [x, z] = this.target, y = this.deck.heightAt(x, z) ?? Math.max(0, water(x, z));
    return new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1]);
  }

  /** From the play space to the world. */
  #world(p) {
    const [x, y, z] = this.#turned(p);
    return [x + this.place[0], y + this.place[1], z + this.place[2]];
  }

  #turned([x, y, z]) {
    const a = this.yaw * Math.PI / 180, sin = Math.sin(a), cos = Math.cos(a);
    return [cos * x - sin * z, y, sin * x + cos * z];
  }

  /** Puts the wearer's feet at a place. */
  #stand([x, z]) {
    const [hx, , hz] = this.#turned([this.head[0], 0, this.head[2]]);
    this.place[0] = x - hx;
    this.place[2] = z - hz;
    this.floor = this.deck.heightAt(x, z) === null ? 'sea' : 'deck';
  }

  /** Where the ray of the controller that points meets the floor. */
  #point(frame) {
    this.target = null;
    const ray = this.pointing && frame.getPose(this.pointing.targetRaySpace, this.space)?.transform;
    if (!ray) return;
    const from = this.#world([ray.position.x, ray.position.y, ray.position.z]);
    const [dx, dy, dz] = this.#turned([-ray.matrix[8], -ray.matrix[9], -ray.matrix[10]]);
    if (dy >= -0.02) return;
    const meet = (level) => [from[0] + dx * (level - from[1]) / dy, from[2] + dz * (level - from[1]) / dy];
    const onDeck = meet(this.deck.y), [along, across] = this.deck.local(...onDeck);
    const aboard = Math.abs(along) < LENGTH_M / 2 && Math.abs(across) < WIDTH_M / 2 && from[1] > this.deck.y;
    const target = aboard ? onDeck : meet(0);
    if (Math.hypot(target[0] - from[0], target[1] - from[2]) <= FARTHEST_M && from[1] > (aboard ? this.deck.y : 0)) this.target = target;
  }
}
