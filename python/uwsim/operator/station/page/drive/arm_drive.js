// Moves the vehicle's arm while keys, sticks or buttons are held: the jaws by their own, and a chosen part, a joint or
// the hand, by those that otherwise drive the vehicle, which then has no effort.
import { attempt } from '../dom.js';

const PERIOD_MS = 100;
const GRIPPING_N = 1; // less than this is not shown
const clamped = (value) => Math.max(-1, Math.min(1, value));

// Events: 'part' (another one is chosen).
export class ArmDrive extends EventTarget {
  part = ''; // 'hand', a joint's name, or '' for the vehicle
  parts = [''];
  #joints = [];
  #vehicle = '';
  #prefix = '';
  #grip = 0;
  #share = { x: 0, y: 0, z: 0 }; // of the chosen part, ahead, to the left and up
  #timer = 0;

  // camera(): the name of the vehicle's camera in the large view, or ''.
  constructor(station, camera) {
    super();
    this.station = station;
    this.camera = camera;
  }

  begin({ name, prefix, arm = [], can_jog: canJog = false }) {
    this.release();
    [this.#vehicle, this.#prefix, this.#joints] = [name, prefix, arm];
    this.parts = ['', ...(canJog ? ['hand'] : []), ...arm.map((joint) => joint.name)];
    this.choose('');
  }

  get hasJaws() {
    return this.#joints.some((joint) => joint.is_jaw);
  }

  choose(part) {
    this.release();
    this.part = this.parts.includes(part) ? part : '';
    this.dispatchEvent(new Event('part'));
  }

  // Choose the next part, or with -1 the one before.
  next(step) {
    this.choose(this.parts.at((this.parts.indexOf(this.part) + step) % this.parts.length) ?? '');
  }

  // sign: 1 closes the jaws, -1 opens them, while held.
  grip(sign, isHeld) {
    if (!this.hasJaws || (!isHeld && this.#grip !== sign)) return;
    this.#grip = isHeld ? sign : 0;
    this.#send();
  }

  // Take the efforts of keys and sticks for the chosen part. Return those that are left for the vehicle.
  take(efforts) {
    if (!this.part) return efforts;
    const { surge, sway, heave } = efforts;
    const isSame = surge === this.#share.x && sway === this.#share.y && heave === this.#share.z;
    this.#share = { x: surge, y: sway, z: heave };
    if (!isSame) this.#send();
    return Object.fromEntries(Object.keys(efforts).map((axis) => [axis, 0]));
  }

  release() {
    const was = this.#isHeld;
    [this.#grip, this.#share] = [0, { x: 0, y: 0, z: 0 }];
    if (was) this.#send();
  }

  // Texts of the arm for the head-up display: { short, text } each. joints, torques: see Telemetry.
  shown({ joints, torques }, nameOf) {
    const found = [];
    const chosen = this.#joints.find((joint) => joint.name === this.part);
    const at = joints.get(`${this.#prefix}${this.part}`);
    if (this.part)
      found.push({
        short: `${nameOf('arm')} ${nameOf(this.part)}`,
        text: chosen && at !== undefined ? positionText(chosen, at) : '',
      });
    const forces = this.#joints.map((joint) => [joint, torques.get(`${this.#prefix}${joint.name}`) ?? 0]);
    const jaws = forces.filter(([joint]) => joint.is_jaw);
    const [jaw, force] = jaws.toSorted(([, a], [, b]) => Math.abs(b) - Math.abs(a))[0] ?? [null, 0];
    if (jaw && (Math.abs(force) > GRIPPING_N || this.#grip))
      found.push({ short: nameOf('grip'), text: forceText(jaw, force) });
    else if (chosen && !chosen.is_jaw)
      found.push({ short: '', text: forceText(chosen, forces.find(([joint]) => joint === chosen)?.[1]) });
    return found;
  }

  get #isHeld() {
    return this.#grip !== 0 || Object.values(this.#share).some(Boolean);
  }

  #send() {
    clearTimeout(this.#timer);
    if (this.#isHeld) this.#timer = setTimeout(() => this.#send(), PERIOD_MS);
    if (!this.#vehicle || !this.station.isPilot) return;
    const { x, y, z } = this.#share;
    const isHand = this.part === 'hand';
    attempt(
      this.station.moveArm({
        vehicle: this.#vehicle,
        joints: this.part && !isHand ? { [this.part]: clamped(x + z) } : {},
        hand: isHand ? [x, y, z] : [0, 0, 0],
        camera: this.camera(),
        grip: this.#grip,
        stamp_ms: performance.now(),
      }),
    );
  }
}

const DEG = 180 / Math.PI;

// A joint's position and its motor's force or torque, in words.
export const positionText = ({ is_slide: isSlide }, value) =>
  isSlide ? `${value.toFixed(3)} m` : `${(DEG * value).toFixed(1)}°`;
const forceText = ({ is_slide: isSlide }, value = 0) =>
  isSlide ? `${Math.abs(value).toFixed(0)} N` : `${Math.abs(value).toFixed(1)} N m`;
