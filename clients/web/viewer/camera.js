// Where we look from: flies with W A S D Q E or a touch, turns with the mouse or a drag.

import { Lift } from './lift.js';

const RADIANS = Math.PI / 180;
const TURN_PER_PIXEL = 0.12; // degrees

export class Camera {
  /**
   * @param {number[]} eye metres
   * @param {number[]} look yaw clockwise from north and pitch up, degrees
   */
  constructor(eye, look) {
    this.eye = [...eye];
    this.yaw = look[0];
    this.pitch = look[1];
    this.fov = 55 * RADIANS; // vertical
    this.keys = new Set();
    this.thrust = 0; // of a second finger
    this.lift = new Lift();
    this.frame = { right: [0, 0, 0], up: [0, 0, 0], forward: [0, 0, 0], near: 0.3 };
  }

  /** Axes of the view, unit vectors. */
  axes() {
    const { right, up, forward } = this.frame;
    const cy = Math.cos(this.yaw * RADIANS), sy = Math.sin(this.yaw * RADIANS);
    const cp = Math.cos(this.pitch * RADIANS), sp = Math.sin(this.pitch * RADIANS);
    right[0] = cy; right[1] = 0; right[2] = sy;
    up[0] = -sy * sp; up[1] = cp; up[2] = cy * sp;
    forward[0] = sy * cp; forward[1] = sp; forward[2] = -cy * cp;
    this.frame.near = Math.min(2, Math.max(0.1, 0.05 * this.eye[1]));
    return this.frame;
  }

  /** @param {HTMLElement} element takes the pointer; keys come from the window */
  attach(element) {
    const pointers = new Map();
    element.addEventListener('pointerdown', (e) => {
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
      element.setPointerCapture(e.pointerId);
    });
    element.addEventListener('pointermove', (e) => {
      const last = pointers.get(e.pointerId);
      if (!last) return;
      const dx = e.clientX - last[0], dy = e.clientY - last[1];
      last[0] = e.clientX;
      last[1] = e.clientY;
      if (pointers.size > 1) {
        this.thrust = Math.max(-1, Math.min(1, this.thrust - dy * 0.02));
      } else {
        this.yaw -= dx * TURN_PER_PIXEL;
        this.pitch = Math.max(-89, Math.min(89, this.pitch + dy * TURN_PER_PIXEL));
      }
    });
    const end = (e) => {
      pointers.delete(e.pointerId);
      if (pointers.size < 2) this.thrust = 0;
    };
    element.addEventListener('pointerup', end);
    element.addEventListener('pointercancel', end);
    element.addEventListener('wheel', (e) => {
      e.preventDefault();
      this.eye[1] = Math.max(0.5, Math.min(3000, this.eye[1] * Math.exp(e.deltaY * 0.001)));
    }, { passive: false });
    addEventListener('keydown', (e) => {
      if (e.target.closest?.('input, select, button') || e.ctrlKey || e.metaKey || e.altKey) return;
      this.keys.add(e.code);
    });
    addEventListener('keyup', (e) => this.keys.delete(e.code));
    addEventListener('blur', () => this.keys.clear());
  }

  /**
   * @param {number} seconds since the last call
   * @param {number} water height of the water below the eye, metres
   */
  move(seconds, water) {
    const on = (...codes) => (codes.some((c) => this.keys.has(c)) ? 1 : 0);
    const ahead = on('KeyW', 'ArrowUp') - on('KeyS', 'ArrowDown') + this.thrust;
    const side = on('KeyD', 'ArrowRight') - on('KeyA', 'ArrowLeft');
    const rise = on('KeyE', 'Space') - on('KeyQ', 'KeyC');
    const { right, forward } = this.axes();
    const speed = (3 + this.eye[1] * 0.8) * (on('ShiftLeft', 'ShiftRight') ? 4 : 1) * Math.min(seconds, 0.1);
    for (let i = 0; i < 3; i++) this.eye[i] += (forward[i] * ahead + right[i] * side) * speed;
    this.eye[1] = Math.min(3000, this.eye[1] + rise * speed * 0.5);
    this.eye[1] = this.lift.above(this.eye[1] - this.lift.metres, water, seconds);
  }

  /** Edges of the view as tangents, for a picture of this shape. */
  tangents(aspect) {
    const upper = Math.tan(this.fov / 2);
    return [-upper * aspect, upper * aspect, -upper, upper];
  }
}
