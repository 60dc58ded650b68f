// Two on-screen sticks for touch: the left one climbs and turns, the right one moves ahead and sideways.
import { el } from '../dom.js';

const REACH_PX = 44;
const STICKS = {
  left: { x: ['yaw', -1], y: ['heave', 1], name: 'Up, down and turn' },
  right: { x: ['sway', -1], y: ['surge', 1], name: 'Ahead and sideways' },
};

export class Touch {
  axes = {};
  element = el('div', { className: 'sticks', 'aria-hidden': 'true' });
  #changed;
  #allowed;

  // Only for touch, since a computer with a mouse has a keyboard.
  constructor({ changed, allowed }) {
    [this.#changed, this.#allowed] = [changed, allowed];
    for (const side of Object.keys(STICKS)) this.element.append(this.#stick(side));
  }

  addTo(axes) {
    for (const [axis, value] of Object.entries(this.axes)) axes[axis] += value;
  }

  drop() {
    this.axes = {};
    for (const knob of this.element.querySelectorAll('i')) knob.style.transform = '';
  }

  #stick(side) {
    const { x, y, name } = STICKS[side];
    const knob = el('i');
    const stick = el('div', { className: `stick ${side}`, title: name }, knob);
    let centre = null;
    const move = (event) => {
      if (!centre) return;
      const part = (value) => Math.max(-1, Math.min(1, value / REACH_PX));
      const [right, up] = [part(event.clientX - centre[0]), part(centre[1] - event.clientY)];
      knob.style.transform = `translate(${right * REACH_PX}px, ${-up * REACH_PX}px)`;
      this.axes[x[0]] = x[1] * right;
      this.axes[y[0]] = y[1] * up;
      this.#changed();
    };
    const end = () => {
      if (!centre) return;
      centre = null;
      knob.style.transform = '';
      delete this.axes[x[0]];
      delete this.axes[y[0]];
      this.#changed();
    };
    stick.addEventListener('pointerdown', (event) => {
      if (!this.#allowed()) return;
      stick.setPointerCapture(event.pointerId);
      const box = stick.getBoundingClientRect();
      centre = [box.left + box.width / 2, box.top + box.height / 2];
      move(event);
    });
    stick.addEventListener('pointermove', move);
    for (const kind of ['pointerup', 'pointercancel', 'lostpointercapture']) stick.addEventListener(kind, end);
    return stick;
  }
}
