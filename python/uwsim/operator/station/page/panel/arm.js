// The joints of the vehicle's arm: their positions, and a slider each, which commands where a motor turns to; the part
// that the driving keys move, and buttons for the jaws.
import { attempt, el, write } from '../dom.js';
import { positionText } from '../drive/arm_drive.js';

const MOMENT_MS = 250;
const STEPS = 200; // of a slider, between a joint's stops

// The name of a part of the arm as shown: its joint's, or in words.
export const partName = (part) => ({ '': 'vehicle', hand: 'hand', arm: 'Arm', grip: 'GRIP' })[part] ?? part;

export class Arm {
  #vehicle = '';
  #joints = []; // { joint, topic, slider, value, isHeld }

  // drive: see ArmDrive.
  constructor(station, telemetry, drive) {
    this.station = station;
    this.telemetry = telemetry;
    this.drive = drive;
    this.part = el('select', { id: 'arm-part', 'aria-label': 'Keys and sticks move' });
    this.part.addEventListener('change', () => {
      drive.choose(this.part.value);
      this.part.blur(); // the keys drive again
    });
    drive.addEventListener('part', () => this.#showPart());
    this.jaws = el(
      'div',
      { className: 'row', role: 'group', 'aria-label': 'Jaws' },
      this.#jawButton('Open', -1),
      this.#jawButton('Close', 1),
    );
    this.list = el('div', { className: 'joints' });
    this.halt = el('button', { type: 'button', id: 'halt-arm' }, 'Halt');
    this.halt.addEventListener('click', () =>
      this.#command({ speeds: Object.fromEntries(this.#joints.map(({ joint }) => [joint.name, 0])) }),
    );
    this.element = el(
      'section',
      { id: 'arm', className: 'arm', hidden: true },
      el('h2', {}, 'Arm', this.halt),
      el('label', {}, el('span', {}, 'Keys and sticks move'), this.part),
      this.jaws,
      this.list,
    );
  }

  begin({ name, prefix, arm = [] }) {
    this.#vehicle = name;
    this.element.hidden = arm.length === 0;
    this.#joints = arm.map((joint) => {
      const slider = el('input', {
        type: 'range',
        'aria-label': joint.name,
        min: String(joint.low),
        max: String(joint.high),
        step: String((joint.high - joint.low) / STEPS),
      });
      const entry = { joint, topic: `${prefix}${joint.name}`, slider, value: el('small', {}, '–'), isHeld: false };
      slider.addEventListener('input', () => {
        entry.isHeld = true; // the slider is where the pilot has put it, not where the joint is
        this.#command({ positions: { [joint.name]: Number(slider.value) } });
      });
      slider.addEventListener('change', () => (entry.isHeld = false));
      return entry;
    });
    this.list.replaceChildren(
      ...this.#joints.map(({ joint, slider, value }) =>
        el('label', {}, el('span', {}, joint.name, ' ', value), slider),
      ),
    );
  }

  show(isStale) {
    this.list.classList.toggle('is-stale', isStale);
    for (const { joint, topic, slider, value, isHeld } of this.#joints) {
      const at = this.telemetry.joints.get(topic);
      if (at === undefined) continue;
      write(value, positionText(joint, at));
      if (!isHeld && document.activeElement !== slider) slider.value = String(at);
    }
  }

  #showPart() {
    const { part, parts, hasJaws } = this.drive;
    this.jaws.hidden = !hasJaws;
    this.part.replaceChildren(
      ...parts.map((value) => el('option', { value, selected: value === part }, partName(value))),
    );
  }

  // A button that moves the jaws while it is held; by keyboard, for a moment.
  #jawButton(text, sign) {
    const button = el('button', { type: 'button' }, text);
    button.addEventListener('pointerdown', () => this.drive.grip(sign, true));
    for (const kind of ['pointerup', 'pointerleave', 'pointercancel'])
      button.addEventListener(kind, () => this.drive.grip(sign, false));
    button.addEventListener('click', (event) => {
      if (event.detail > 0) return;
      this.drive.grip(sign, true);
      setTimeout(() => this.drive.grip(sign, false), MOMENT_MS);
    });
    return button;
  }

  #command(args) {
    attempt(this.station.command('set_joints', this.#vehicle, args));
  }
}
