// The sea that is held, at any moment: frames of every cascade and group, joined in time. Knows nothing of pixels.
//
// While the layout changes there are cascades of two; each counts at its own ticks alone, so none begins or ends with
// a step. A unit that comes at another level or rate takes over once its frames reach the moment that is shown.

import { GROUP_CHANNELS, GROUPS } from './frame.js';
import { isThere, REST_TICKS, TICKS_PER_SECOND } from './messages.js';
import { Unit } from './unit.js';

/** Most cascades: eight of a layout, and eight of the one that follows it. */
export const MOST_CASCADES = 16;
const FOAM = GROUPS.indexOf('foam');
const DISPLACEMENT = GROUPS.indexOf('displacement');
const ROUNDS = 3; // of looking for the particle that is now at a place

/**
 * @typedef {import('./messages.js').Cascade} Cascade
 * @typedef {import('./plan.js').Plan} Plan
 * @typedef {object} Sampled one group of one cascade at a moment
 * @property {Cascade} cascade
 * @property {string} group
 * @property {number} n samples a side
 * @property {Float32Array} values `[channel][z][x]`, metres (or 1); sample (0, 0) of each patch lies at the world's origin
 * @property {boolean} starved the moment lies outside the frames held: the nearest is shown
 */

export class Playback {
  /**
   * @param {{cascades: Cascade[]}} layout of `hello`
   * @param {Plan} plan
   * @param {Playback | null} before of the same sea: frames of cascades that go on are taken from there, and the rest of
   *   it is let go of
   */
  constructor(layout, plan, before = null) {
    this.plan = plan;
    this.cascades = layout.cascades.slice(0, MOST_CASCADES);
    const none = () => this.cascades.map(() => GROUPS.map(() => /** @type {Unit | null} */ (null)));
    /** Units by layer (place in `cascades`), then group; null where none is subscribed. */
    this.units = none();
    /** The same at another level or rate, of which frames come that are not shown yet. */
    this.coming = none();
    /** What was granted, by layer and group: finest level that comes, and ticks between frames. */
    this.granted = this.cascades.map(() => GROUPS.map(() => ({ level: 0, interval: 0 })));
    this.layers = new Map(this.cascades.map((c, layer) => [c.index, layer]));
    for (const u of plan.units) {
      const group = GROUPS.indexOf(u.group), layer = this.layers.get(u.cascade);
      if (layer === undefined || group < 0) continue;
      const interval = TICKS_PER_SECOND / (u.rate_hz ?? plan.rateHz);
      this.granted[layer][group] = { level: u.level, interval };
      const held = before?.take(this.cascades[layer], group);
      this.units[layer][group] = held?.unit ?? this.#unit(layer, group, u.level);
      const fits = (/** @type {Unit | null | undefined} */ unit) => unit?.level === u.level && unit.ring.interval <= interval;
      if (held?.next && fits(held.next) && !fits(held.unit)) this.coming[layer][group] = held.next;
      else held?.next?.dispose();
    }
    /** Everything that is subscribed was there once, foam aside; a cascade that is added then begins as nothing. */
    this.complete = before?.complete ?? false;
    this.foamy = false; // and foam
    this.starved = false;
    /** @type {number[]} layers that are part of the sea at the moment */
    this.active = [];
    this.finest = 0; // of those, the one with the shortest waves
    this.tick = NaN;
    /** @type {import('./decode.js').DecodedFrame[]} frames that newer ones took the place of, for who recycles them */
    this.spent = [];
    before?.dispose();
  }

  /**
   * @param {import('./decode.js').DecodedFrame} frame
   * @returns {boolean} whether it was of use
   */
  accept(frame) {
    const layer = this.layers.get(frame.cascade), { group, level, levelN } = frame;
    const unit = layer === undefined ? null : this.units[layer][group];
    if (layer === undefined || !unit) return false;
    const granted = this.granted[layer][group];
    this.tick = NaN; // what was chosen for a moment may lie elsewhere now
    /** @type {(held: Unit | null) => boolean} */
    const fits = (held) => held !== null && held.level === level && held.ring.interval <= granted.interval;
    this.spent.length = 0;
    if (fits(unit)) return unit.accept(frame, this.spent);
    // The server sends it coarser than it was granted, or fine again; or another level or rate was asked for. Where only
    // the rate differs, what is shown goes on with the frames that it has a place for.
    const shown = unit.level === level && unit.accept(frame);
    const coming = this.coming[layer];
    if (!fits(coming[group])) {
      if (level < granted.level || level >= 32 || this.cascades[layer].n >>> level !== levelN) return shown;
      coming[group]?.dispose();
      coming[group] = this.#unit(layer, group, level);
    }
    return coming[group]?.accept(frame) || shown; // of two units, maybe: none of these is spent
  }

  /** Every unit that is held. */
  all() {
    return [...this.units.flat(), ...this.coming.flat()].filter((unit) => unit !== null);
  }

  /** The levels that are shown, the finest first. */
  levels() {
    return [...new Set(this.units.flat().flatMap((unit) => (unit ? [unit.level] : [])))].sort((a, b) => a - b);
  }

  /**
   * Gives away a unit of a cascade that goes on, with its frames, and the one that is coming in its place; they may be of
   * another level or rate than will come.
   * @param {Cascade} cascade
   * @param {number} group
   */
  take(cascade, group) {
    const layer = this.layers.get(cascade.index);
    if (layer === undefined) return null;
    const { from_tick: from, n } = this.cascades[layer];
    if (from !== cascade.from_tick || n !== cascade.n) return null;
    const unit = this.units[layer][group], next = this.coming[layer][group];
    this.units[layer][group] = this.coming[layer][group] = null;
    return { unit, next };
  }

  /**
   * Goes to a moment: what is sampled, drawn and asked for is of it.
   * @param {number} tick not a whole number in general
   * @returns {boolean} starved: some unit has no frame on one side of it
   */
  seek(tick) {
    this.tick = tick;
    this.#choose(tick);
    let starved = false, complete = this.active.length > 0, foamy = true;
    for (const layer of this.active) {
      const { until_tick: until } = this.cascades[layer];
      const rests = until !== null && tick >= until - REST_TICKS; // its last frames are nothing
      for (let group = 0; group < GROUPS.length; group++) {
        const pick = this.#shown(layer, group, tick)?.seek(tick);
        if (!pick) continue;
        if (pick.points > 0) starved ||= pick.starved && !rests;
        else if (group === FOAM) foamy = false;
        else complete = false;
      }
    }
    this.complete ||= complete;
    this.foamy = complete && foamy;
    this.starved = starved;
    return starved;
  }

  /**
   * Everything that is held, at a moment.
   * @param {number} tick
   * @param {string[]} groups which to sample; all that is subscribed without
   * @returns {Sampled[]} in memory that the next call uses again, and may move
   */
  sample(tick, groups = GROUPS) {
    this.seek(tick);
    const units = this.active.flatMap((layer) => this.units[layer].flatMap((unit, group) => {
      if (!unit || unit.pick.points === 0 || !groups.includes(GROUPS[group])) return [];
      return [{ unit, cascade: this.cascades[layer], group: GROUPS[group] }];
    }));
    for (const { unit } of units) unit.prepare(); // first: where memory grows, what was sampled before goes
    return units.map(({ unit, cascade, group }) => (
      { cascade, group, n: unit.size, values: unit.sample(), starved: unit.pick.starved }));
  }

  /**
   * The height of the water above a place of the world, at the moment last sought: of the particle that is there now,
   * found by three steps of fixed-point iteration, bilinear between samples.
   * @param {number} x metres
   * @param {number} z
   * @returns {number} metres above the rest surface; NaN before there is displacement of every cascade once
   */
  heightAt(x, z) {
    const known = this.active.some((layer) => this.units[layer][DISPLACEMENT]?.pick.points);
    if (!this.complete || !known) return NaN;
    let [dx, height, dz] = this.displacementAt(x, z);
    for (let round = 0; round < ROUNDS; round++) [dx, height, dz] = this.displacementAt(x - dx, z - dz);
    return height;
  }

  /**
   * How far the particle that rests at a place is from it, at the moment last sought.
   * @param {number} x0 metres
   * @param {number} z0
   * @returns {[number, number, number]} x, y, z in metres
   */
  displacementAt(x0, z0) {
    /** @type {[number, number, number]} */
    const sum = [0, 0, 0];
    for (const layer of this.active) {
      const patch = this.cascades[layer].patch_m;
      this.units[layer][DISPLACEMENT]?.add(x0 / patch, z0 / patch, sum);
    }
    return sum;
  }

  /**
   * Ticks of frames held ahead of a time by the unit that has the fewest; foam may not be warm yet.
   * @param {number} tick
   */
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

  /** Lets go of everything. */
  dispose() {
    for (const held of [this.units, this.coming]) {
      for (const units of held) units.forEach((_, group) => { units[group]?.dispose(); units[group] = null; });
    }
  }

  /** @param {number} layer @param {number} group @param {number} level */
  #unit(layer, group, level) {
    const size = this.cascades[layer].n >>> level;
    return new Unit(group, GROUP_CHANNELS[group], size, this.granted[layer][group].interval, level);
  }

  /**
   * Chooses the layers of a moment, and lets go of those that are over.
   * @param {number} tick
   */
  #choose(tick) {
    this.active.length = 0;
    let lasting = -1, ending = -1;
    this.cascades.forEach((cascade, layer) => {
      if (isThere(cascade, tick)) {
        this.active.push(layer);
        if (cascade.until_tick === null) lasting = layer; else ending = layer;
        return;
      }
      // Not at once, lest a look ahead of the moment that is shown takes it away.
      const over = cascade.until_tick !== null && tick >= cascade.until_tick + TICKS_PER_SECOND;
      for (const held of [this.units, this.coming]) {
        held[layer].forEach((unit, group) => {
          if (unit) unit.pick.points = 0;
          if (!unit || !over) return;
          unit.dispose();
          held[layer][group] = null;
        });
      }
    });
    this.finest = lasting < 0 ? Math.max(0, ending) : lasting;
    if (lasting >= 0 && ending >= 0) {
      const middle = (this.cascades[lasting].from_tick + (this.cascades[ending].until_tick ?? Infinity)) / 2;
      if (tick < middle) this.finest = ending;
    }
  }

  /**
   * The unit to show; one of another level or rate takes over once its frames reach back to the moment.
   * @param {number} layer
   * @param {number} group
   * @param {number} tick
   */
  #shown(layer, group, tick) {
    const unit = this.units[layer][group], next = this.coming[layer][group];
    if (!next || !unit || !(next.ring.reaches(tick) || unit.ring.newest < 0)) return unit;
    unit.dispose();
    this.coming[layer][group] = null;
    this.units[layer][group] = next;
    return next;
  }
}
