// Converts keys, gamepads and touch to efforts, sent on each change and five times a second while held.
import { targetOf, toast } from '../dom.js';
import { AXES } from '../wire/messages.js';
import { ALL_STOP } from './bindings.js';
import { Gamepads } from './gamepad.js';
import { Keys } from './keys.js';
import { Touch } from './touch.js';

const PERIOD_MS = 200;
const LEAST_MS = 40; // minimum between two commands of a moving stick
const GAINS = [0.1, 0.25, 0.5, 0.75, 1];
const none = () => Object.fromEntries(AXES.map((axis) => [axis, 0]));
const isZero = (efforts) => AXES.every((axis) => efforts[axis] === 0);

// Events: 'efforts' (the requested efforts changed), 'gain', 'answer' (detail: milliseconds to the server and back).
export class Pilot extends EventTarget {
  efforts = none();
  answers_ms = []; // of the last commands, for display and for benchmarks
  #gain = GAINS.indexOf(0.5);
  #sentMs = -Infinity;
  #sent = none();
  #timer = 0;
  #isOpen = true; // false while a dialog is open
  #isCruising = false; // whether efforts must be sent although none is held

  // arm: the ArmDrive, which takes the efforts while a part of the arm is chosen.
  constructor(station, bindings, arm, act) {
    super();
    this.station = station;
    this.arm = arm;
    arm.addEventListener('part', () => this.release());
    this.vehicle = '';
    const actNow = (action, isPressed) => (this.mayAct || action === ALL_STOP) && act(action, isPressed);
    this.keys = new Keys(bindings, {
      act: actNow,
      changed: () => this.#read(),
      allowed: () => this.mayAct,
    });
    this.touch = new Touch({ changed: () => this.#read(), allowed: () => this.mayAct });
    this.gamepads = new Gamepads(actNow, toast);
    addEventListener('blur', () => this.release());
    addEventListener('pagehide', () => this.release());
    document.addEventListener('visibilitychange', () => {
      if (document.hidden) this.release();
    });
    document.addEventListener('focusin', (event) => {
      if (targetOf(event).matches('input, select, textarea')) this.release();
    });
    station.addEventListener('close', () => this.release());
    station.addEventListener('state', () => {
      if (!station.isPilot) this.release();
    });
    requestAnimationFrame(() => this.#poll());
  }

  get gain() {
    return GAINS[this.#gain];
  }

  get mayAct() {
    return this.#isOpen && !document.hidden && this.station.isRunning;
  }

  get isHeld() {
    return !isZero(this.efforts);
  }

  changeGain(steps) {
    this.#gain = Math.max(0, Math.min(GAINS.length - 1, this.#gain + steps));
    this.dispatchEvent(new Event('gain'));
    this.#read();
  }

  // A speed hold lasts only while efforts arrive, so send them, even if zero, as long as the pilot is present.
  repeat(isCruising) {
    this.#isCruising = isCruising;
    if (this.#mustRepeat && !this.#timer) this.#later(PERIOD_MS);
  }

  get #mustRepeat() {
    return this.#isCruising && this.mayAct && document.hasFocus();
  }

  // Disable all controls while a dialog is open.
  suspend(isSuspended) {
    this.#isOpen = !isSuspended;
    if (isSuspended) this.release();
  }

  // Release all controls, and send zeros even if zeros were the last efforts sent, since those may have been lost.
  release() {
    this.keys.drop();
    this.gamepads.disarm();
    this.touch.drop();
    this.arm.release();
    this.efforts = none();
    clearTimeout(this.#timer);
    this.#timer = 0;
    if (!isZero(this.#sent)) this.#send();
    this.dispatchEvent(new Event('efforts'));
  }

  // Set all efforts to zero even if keys are held; each key must be pressed again.
  stop() {
    this.release();
    this.#send();
  }

  #poll() {
    if (this.gamepads.poll(this.mayAct && this.station.isPilot)) this.#read();
    requestAnimationFrame(() => this.#poll());
  }

  #read() {
    const axes = none();
    this.keys.addTo(axes);
    this.gamepads.addTo(axes);
    this.touch.addTo(axes);
    for (const axis of AXES) axes[axis] = this.gain * Math.max(-1, Math.min(1, axes[axis]));
    this.efforts = this.arm.take(axes);
    this.dispatchEvent(new Event('efforts'));
    const waitMs = isZero(this.efforts) ? 0 : this.#sentMs + LEAST_MS - performance.now();
    if (waitMs > 0) this.#later(waitMs);
    else this.#send();
  }

  #later(ms) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#send(), ms);
  }

  async #send() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    const begun = performance.now();
    this.#sentMs = begun;
    if (this.isHeld || this.#mustRepeat) this.#later(PERIOD_MS);
    if (!this.station.isPilot) return;
    this.#sent = this.efforts;
    try {
      const answer = await this.station.drive(this.vehicle, this.efforts, begun);
      const ms = performance.now() - begun;
      this.answers_ms = [...this.answers_ms.slice(-199), ms];
      this.dispatchEvent(new CustomEvent('answer', { detail: { ...answer, ms } }));
    } catch {
      /* the banner shows a lost connection; the server sets the efforts to zero */
    }
  }
}
