// The panel: shows numbers, and asks the server for another wind.

import { TICKS_PER_SECOND } from '../src/messages.js';

const POINTS = ['N', 'NNE', 'NE', 'ENE', 'E', 'ESE', 'SE', 'SSE', 'S', 'SSW', 'SW', 'WSW', 'W', 'WNW', 'NW', 'NNW'];

/** Upper bounds of Beaufort 0 to 11, m/s (WMO). */
const BEAUFORT_MPS = [0.3, 1.6, 3.4, 5.5, 8.0, 10.8, 13.9, 17.2, 20.8, 24.5, 28.5, 32.7];

/**
 * @param {number} speedMps
 * @returns {number} 0 to 12
 */
export function beaufort(speedMps) {
  const force = BEAUFORT_MPS.findIndex((most) => speedMps < most);
  return force < 0 ? 12 : force;
}

/** @param {number} degrees clockwise from north */
export function compassPoint(degrees) {
  return POINTS[Math.round((((degrees % 360) + 360) % 360) / 22.5) % 16];
}

/**
 * @param {number} tick
 * @returns {string} hours, minutes and seconds since the sea began
 */
export function seaTime(tick) {
  const seconds = Math.floor(tick / TICKS_PER_SECOND);
  const two = (n) => String(n % 60).padStart(2, '0');
  return `${Math.floor(seconds / 3600)}:${two(Math.floor(seconds / 60))}:${two(seconds)}`;
}

/**
 * @param {string} scene
 * @param {{speed_mps: number, direction_from_deg: number, transition_s: number}} wind
 * @returns {Promise<{accepted: boolean, text: string}>} what to tell the operator
 */
export async function putWind(scene, wind) {
  try {
    const response = await fetch(`v1/scenes/${encodeURIComponent(scene)}/wind`, {
      method: 'PUT',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify(wind),
    });
    const body = await response.json().catch(() => ({}));
    if (response.ok) {
      return { accepted: true, text: `Accepted as change ${body.sequence}, from ${seaTime(body.effective_tick)}.` };
    }
    const title = body.title ?? `Refused (${response.status})`;
    const field = body.field ? ` (${body.field})` : '';
    return { accepted: false, text: body.detail ? `${title}: ${body.detail}${field}` : title + field };
  } catch (error) {
    return { accepted: false, text: `The server can't be reached: ${error.message}` };
  }
}

export class Panel {
  /** @param {Document} document */
  constructor(document) {
    this.at = (id) => document.getElementById(id);
    this.scene = null;
    this.dropped = 0; // pictures that the display could have had
    this.held = false; // the operator has a slider in hand: leave them alone
    for (const id of ['speed', 'direction', 'transition']) {
      const slider = this.at(id);
      slider.addEventListener('input', () => {
        this.held = true;
        this.#label();
      });
      slider.addEventListener('change', () => {
        if (id === 'transition') this.held = false;
        else this.#send();
      });
    }
    this.#label();
  }

  show() {
    this.at('panel').hidden = false;
  }

  /** @param {boolean} connected */
  setState(connected, detail) {
    this.at('state').textContent = connected ? this.scene ?? 'live' : 'reconnecting';
    this.at('state').title = detail;
    if (!connected) this.at('controls').disabled = true;
  }

  /** @param {object} hello */
  setHello(hello) {
    this.scene = hello.scene;
  }

  /** @param {object} status */
  setStatus(status) {
    const { wind } = status;
    this.at('hs').textContent = `${status.hs_m.toFixed(2)} m`;
    this.at('wind').textContent = wind
      ? `${wind.speed_mps.toFixed(1)} m/s ${compassPoint(wind.direction_from_deg)} (Bft ${beaufort(wind.speed_mps)})`
      : 'not wind-driven';
    this.at('controls').disabled = !wind;
    if (!wind) return;
    const [least, most] = status.wind_range_mps ?? [0, 30];
    Object.assign(this.at('speed'), { min: String(least), max: String(most) });
    if (!this.held) {
      this.at('speed').value = String(wind.speed_mps);
      this.at('direction').value = String(Math.round(wind.direction_from_deg) % 360);
      this.#label();
    }
  }

  /** @param {object} change an entry of the control log */
  setChange(change) {
    const { kind, speed_mps: speed } = change.change;
    const what = { wind: `Wind goes to ${speed} m/s`, layout: 'The layout changes' }[kind];
    if (!what) return;
    const over = change.transition_ticks / TICKS_PER_SECOND;
    this.#answer(true, `${what} from ${seaTime(change.effective_tick)}, over ${over} s.`);
  }

  /**
   * A few times a second.
   * @param {{tick: number, boundMs: number, aheadTicks: number, bytesPerSecond: number, decodeMs: number,
   *   rateHz: number, levels: number[], fps: number, pictureMs: number, dropped: number, starved: number, refused: number}} n
   */
  setNumbers(n) {
    const known = Number.isFinite(n.tick);
    this.at('time').textContent = known ? seaTime(n.tick) : '-';
    this.at('tick').textContent = known ? String(Math.floor(n.tick)) : '-';
    this.at('clock').textContent = Number.isFinite(n.boundMs) ? `${n.boundMs.toFixed(2)} ms` : '-';
    this.at('ahead').textContent = `${(n.aheadTicks * 1000 / TICKS_PER_SECOND).toFixed(0)} ms`;
    this.at('bytes').textContent = `${(n.bytesPerSecond / 1e6).toFixed(2)} MB/s`;
    this.at('quality').textContent = n.rateHz ? `${n.rateHz} Hz, level ${n.levels.join(' and ')}` : '-';
    this.at('decode').textContent = Number.isFinite(n.decodeMs) ? `${n.decodeMs.toFixed(1)} ms a tick` : '-';
    this.at('fps').textContent = `${n.fps.toFixed(0)} /s of ${n.pictureMs.toFixed(1)} ms`;
    this.dropped += n.dropped;
    this.at('dropped').textContent = String(this.dropped);
    this.at('starved').textContent = n.refused ? `${n.starved}, ${n.refused} refused` : String(n.starved);
  }

  /** The same in few words, for a board in VR. */
  lines(n) {
    return [
      `${this.at('hs').textContent}, ${this.at('wind').textContent}`,
      `${n.fps.toFixed(0)} pictures/s, ${n.pictureMs.toFixed(1)} ms`,
      `${this.dropped} dropped, ${n.starved} starved`,
      `${n.rateHz} Hz, level ${n.levels.join(' and ')}, clock ${n.boundMs.toFixed(1)} ms`,
    ];
  }

  /** Shows the button to enter VR. */
  offerVr(press) {
    this.at('vr').hidden = false;
    this.at('enter').addEventListener('click', press);
  }

  setImmersed(immersed) {
    this.at('enter').textContent = immersed ? 'Leave VR' : 'Enter VR';
  }

  /** Where to stand in VR: 'deck' or 'sea'. */
  floor() {
    return this.at('floor').value;
  }

  #label() {
    const direction = Number(this.at('direction').value);
    this.at('speedOut').textContent = `${Number(this.at('speed').value).toFixed(1)} m/s`;
    this.at('directionOut').textContent = `${direction}° ${compassPoint(direction)}`;
    this.at('transitionOut').textContent = `${this.at('transition').value} s`;
  }

  #answer(good, text) {
    const answer = this.at('answer');
    answer.textContent = text;
    answer.classList.toggle('bad', !good);
  }

  async #send() {
    if (this.scene === null) return;
    this.#answer(true, 'Asking…');
    const wind = {
      speed_mps: Number(this.at('speed').value),
      direction_from_deg: Number(this.at('direction').value),
      transition_s: Number(this.at('transition').value),
    };
    const { accepted, text } = await putWind(this.scene, wind);
    this.#answer(accepted, text);
    // A change takes a while to be in effect; a refused one never will be.
    clearTimeout(this.release);
    this.release = setTimeout(() => { this.held = false; }, accepted ? (wind.transition_s + 2) * 1000 : 0);
  }
}
