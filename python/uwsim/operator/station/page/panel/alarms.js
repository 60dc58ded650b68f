// The lamps of the paper's panel and one for contact, their sound, which is off by default, and the log of alarms.
import { clockText, el, write } from '../dom.js';
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

export class Alarms {
  /** @type {AudioContext | null} */
  #audio = null;
  #beepedMs = {};
  #lamps = {};
  #isMuted = false;
  #isAsPublished = false;
  log = new AlarmLog();

  constructor() {
    for (const [name, { title }] of Object.entries(LAMPS)) {
      const state = el('span', { className: 'visually-hidden' }, 'off');
      this.#lamps[name] = {
        state,
        title: el('b', {}, title),
      };
      const { title: shown } = this.#lamps[name];
      this.#lamps[name].element = el(
        'div',
        { className: 'lamp', id: `lamp-${name}`, role: 'status' },
        el('i', { 'aria-hidden': 'true' }),
        shown,
        state,
      );
    }
    this.button = el('button', { type: 'button', id: 'sound', onclick: () => this.setSound(!this.isLoud) });
    this.acknowledge = el(
      'button',
      { type: 'button', id: 'acknowledge', className: 'danger', hidden: true, onclick: () => this.#acknowledge() },
      'Acknowledge',
    );
    this.lines = el('ol', { className: 'alarm-log', tabIndex: 0, 'aria-label': 'Alarms, newest first' });
    this.count = el('small', {}, 'none');
    this.element = el(
      'section',
      { className: 'warnings' },
      el('h2', {}, 'Warnings', this.button),
      el('div', { className: 'lamps' }, ...Object.values(this.#lamps).map(({ element }) => element)),
      this.acknowledge,
      el('details', { id: 'alarm-log' }, el('summary', {}, 'Alarm log', ' ', this.count), this.lines),
    );
    this.isLoud = false;
    this.#showSound(localStorage.getItem(STORED));
  }

  setSound(isLoud) {
    localStorage.setItem(STORED, isLoud ? 'on' : 'off');
    this.#showSound(isLoud ? 'on' : 'off');
  }

  // Warn a pilot that data no longer arrive: also with the sound in its default state, but not if it was switched off.
  warnOfSilence() {
    if (!this.#isMuted) this.#beep('silence', SILENCE.beep, SILENCE.period_ms);
  }

  #showSound(stored) {
    this.isLoud = stored === 'on';
    this.#isMuted = stored === 'off';
    this.button.setAttribute('aria-pressed', String(this.isLoud));
    write(this.button, this.isLoud ? 'Sound on' : 'Sound off');
  }

  #acknowledge() {
    this.log.acknowledge();
    this.acknowledge.hidden = true;
  }

  // The published panel has one lamp for the bed, Proximity, which is red, and none for contact.
  setPublished(isAsPublished) {
    this.#isAsPublished = isAsPublished;
    write(this.#lamps.bed.title, isAsPublished ? 'Proximity' : 'Bed');
    this.#lamps.contact.element.hidden = isAsPublished;
  }

  // The collision lamp stays on until a collision is acknowledged. The contact lamp follows the echoes around the
  // vehicle and the time to contact; the others follow the fields of the wire.
  #isOn(name, message, contact, nearest_m) {
    if (name === 'collision' && this.log.collisions > 0) return true;
    if (name === 'contact') return !this.#isAsPublished && (contact !== null || nearest_m < NEAR_M);
    return Boolean(message?.[LAMPS[name].field]);
  }

  #showLog() {
    const { entries } = this.log;
    write(this.count, entries.length ? String(entries.length) : 'none');
    this.lines.replaceChildren(
      ...entries.map(({ time_s, text }) => el('li', {}, el('time', {}, clockText(time_s)), ` ${text}`)),
    );
  }

  show(message, isStale, { time_s = NaN, contact = null, nearest_m = NaN } = {}) {
    if (message && !isStale && this.log.update(message, time_s, contact)) this.#showLog();
    const { collisions } = this.log;
    this.acknowledge.hidden = collisions === 0;
    write(this.acknowledge, `Acknowledge ${collisions === 1 ? '1 collision' : `${collisions} collisions`}`);
    for (const [name, { level, beep, period_ms }] of Object.entries(LAMPS)) {
      const { element, state } = this.#lamps[name];
      const isOn = this.#isOn(name, message, contact, nearest_m);
      element.dataset.on = !isOn ? 'off' : this.#isAsPublished ? 'alarm' : level;
      element.classList.toggle('is-stale', isStale);
      write(state, isOn ? 'on' : 'off');
      if (isOn && this.isLoud && !isStale) this.#beep(name, beep, period_ms);
    }
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
