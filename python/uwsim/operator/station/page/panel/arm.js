// The joints of the vehicle's arm: their positions, and a slider each, which commands where a motor turns to.
import { attempt, el, fixed, write } from '../dom.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.arm;
const DEG = 180 / Math.PI;
const STEPS = 200; // of a slider, between a joint's stops

const text = ({ is_slide: isSlide }, value) => (isSlide ? `${fixed(value, 3)} m` : `${fixed(DEG * value, 1)}°`);

export class Arm {
  #vehicle = '';
  #joints = []; // { joint, topic, slider, value, isHeld }

  constructor(station, telemetry) {
    this.station = station;
    this.telemetry = telemetry;
    this.list = el('div', { className: 'joints' });
    this.halt = el('button', { type: 'button', id: 'halt-arm' }, WORDS.halt);
    this.halt.addEventListener('click', () =>
      this.#command({ speeds: Object.fromEntries(this.#joints.map(({ joint }) => [joint.name, 0])) }),
    );
    this.element = el(
      'section',
      { id: 'arm', className: 'arm', hidden: true },
      el('h2', {}, WORDS.arm, this.halt),
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
      write(value, text(joint, at));
      if (!isHeld && document.activeElement !== slider) slider.value = String(at);
    }
  }

  #command(args) {
    attempt(this.station.command('set_joints', this.#vehicle, args));
  }
}
