// The lamps of the paper's panel and one for contact, their sound, which is off by default, and the log of alarms.
import { clockText, part } from '../dom.js';
import { html, signal } from '../vendor/preact.js';
import { AlarmLog } from './alarm_log.js';

const STORED = 'uwsim.sound';
const NEAR_M = 2; // of the nearest echo, some two lengths of a vehicle, at which the contact lamp lights
/** Pitch [Hz] and length [s] of each beep, so that they can be distinguished by ear.
 * @type {Record<string, { title: string, level: string, field: string, beep: [number, number], period_ms: number }>}
 */
const LAMPS = {
  range: { title: 'Range', level: 'warn', field: 'range_warning', beep: [440, 0.12], period_ms: 3000 },
  bed: { title: 'Bed', level: 'warn', field: 'proximity_warning', beep: [590, 0.12], period_ms: 3000 },
  contact: { title: 'Contact', level: 'warn', field: '', beep: [740, 0.1], period_ms: 1500 },
  collision: { title: 'Collision', level: 'alarm', field: 'collision_warning', beep: [1050, 0.18], period_ms: 500 },
};

/** @type {{ beep: [number, number], period_ms: number }} */
const SILENCE = { beep: [300, 0.4], period_ms: 1000 }; // nothing arrives from the simulator

const Log = part(
  ({ entries }) => html`
    <details id="alarm-log">
      <summary>Alarm log <small>${entries.length || 'none'}</small></summary>
      <ol class="alarm-log" tabindex="0" aria-label="Alarms, newest first">
        ${entries.map(({ time_s, text }) => html`<li><time>${clockText(time_s)}</time> ${text}</li>`)}
      </ol>
    </details>
  `,
);

export class Alarms {
  /** @type {AudioContext | null} */
  #audio = null;
  #beepedMs = {};
  /** @type {string[]} */
  #lit = []; // names of lamps
  #stored = signal(localStorage.getItem(STORED));
  #collisions = signal(0); // that are not acknowledged
  log = new AlarmLog();
  isAsPublished = false; // the published panel has one lamp for the bed, Proximity, which is red, and none for contact

  get isLoud() {
    return this.#stored.value === 'on';
  }

  setSound(isLoud) {
    this.#stored.value = isLoud ? 'on' : 'off';
    localStorage.setItem(STORED, this.#stored.value);
  }

  // Warn a pilot that data no longer arrive: also with the sound in its default state, but not if it was switched off.
  warnOfSilence() {
    if (this.#stored.value !== 'off') this.#beep('silence', SILENCE.beep, SILENCE.period_ms);
  }

  #acknowledge() {
    this.log.acknowledge();
    this.#collisions.value = 0;
  }

  // The collision lamp stays on until a collision is acknowledged. The contact lamp follows the echoes around the
  // vehicle and the time to contact, if there is one; the others follow the fields of the wire.
  hear(message, isStale, { time_s = NaN, contact = null, nearest_m = NaN } = {}) {
    if (message && !isStale) this.log.update(message, time_s, contact);
    const isNear = !this.isAsPublished && (contact !== null || nearest_m < NEAR_M);
    this.#collisions.value = this.log.collisions;
    this.#lit = Object.keys(LAMPS).filter(
      (name) =>
        (name === 'collision' && this.log.collisions > 0) ||
        (name === 'contact' ? isNear : message?.[LAMPS[name].field]),
    );
    if (this.isLoud && !isStale)
      for (const name of this.#lit) this.#beep(name, LAMPS[name].beep, LAMPS[name].period_ms);
  }

  view(isStale) {
    const { isAsPublished } = this;
    const count = this.#collisions.value;
    const lamp = ([name, { title, level }]) => {
      const isOn = this.#lit.includes(name);
      const on = !isOn ? 'off' : isAsPublished ? 'alarm' : level;
      return html`
        <div class="lamp ${isStale ? 'is-stale' : ''}" id="lamp-${name}" role="status" data-on=${on}
          hidden=${isAsPublished && name === 'contact'}>
          <i aria-hidden="true" /><b>${isAsPublished && name === 'bed' ? 'Proximity' : title}</b>
          <span class="visually-hidden">${isOn ? 'on' : 'off'}</span>
        </div>
      `;
    };
    return html`
      <section class="warnings">
        <h2>Warnings
          <button type="button" id="sound" aria-pressed=${this.isLoud} onClick=${() => this.setSound(!this.isLoud)}>
            ${this.isLoud ? 'Sound on' : 'Sound off'}
          </button>
        </h2>
        <div class="lamps">${Object.entries(LAMPS).map(lamp)}</div>
        <button type="button" id="acknowledge" class="danger" hidden=${!count} onClick=${() => this.#acknowledge()}>
          Acknowledge ${count === 1 ? '1 collision' : `${count} collisions`}
        </button>
        <${Log} entries=${this.log.entries} />
      </section>
    `;
  }

  #beep(name, [hertz, seconds], period_ms) {
    const now = performance.now();
    if (now - (this.#beepedMs[name] ?? -Infinity) < period_ms) return;
    this.#beepedMs[name] = now;
    this.#audio ??= new AudioContext();
    if (this.#audio.state === 'suspended') this.#audio.resume();
    const [tone, volume, start] = [this.#audio.createOscillator(), this.#audio.createGain(), this.#audio.currentTime];
    tone.frequency.value = hertz;
    volume.gain.setValueAtTime(0.0001, start);
    volume.gain.exponentialRampToValueAtTime(0.2, start + 0.01);
    volume.gain.exponentialRampToValueAtTime(0.0001, start + seconds);
    tone.connect(volume).connect(this.#audio.destination);
    tone.start(start);
    tone.stop(start + seconds + 0.02);
  }
}
