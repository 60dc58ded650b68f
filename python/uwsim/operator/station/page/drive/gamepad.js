// Gamepads with the standard mapping of https://www.w3.org/TR/gamepad: sticks as efforts, buttons as actions.

import { ALL_STOP } from './bindings.js';

const DEAD_ZONE = 0.12;
// Sticks as on most ROVs: the left one climbs and turns, the right one goes ahead and sideways.
const STICKS = [
  ['yaw', -1],
  ['heave', -1],
  ['sway', -1],
  ['surge', -1],
];
const BUTTONS = {
  0: 'stop',
  1: 'mark',
  2: 'frontOn',
  3: 'frontOff',
  4: 'gainDown',
  5: 'gainUp',
  8: 'pause',
  9: 'release',
  12: 'tiltUp',
  13: 'tiltDown',
  14: 'downOff',
  15: 'downOn',
};

export class Gamepads {
  #pressed = new Set();
  #act;
  axes = {};
  name = '';

  constructor(act) {
    this.#act = act;
  }

  get isHeld() {
    return Object.values(this.axes).some((value) => value !== 0);
  }

  // Read all gamepads; called once per frame. Return whether an axis has changed.
  poll(isAllowed) {
    const pads = (navigator.getGamepads?.() ?? []).filter((pad) => pad?.connected);
    this.name = pads[0]?.id ?? '';
    const axes = {};
    const pressed = new Set();
    for (const pad of pads) {
      STICKS.forEach(([axis, sign], k) => {
        axes[axis] = (axes[axis] ?? 0) + sign * shaped(pad.axes[k] ?? 0);
      });
      pad.buttons.forEach((button, k) => {
        if (button.pressed && BUTTONS[k]) pressed.add(BUTTONS[k]);
      });
    }
    if (!isAllowed) {
      for (const axis of Object.keys(axes)) axes[axis] = 0;
      for (const action of pressed) if (action !== ALL_STOP) pressed.delete(action);
    }
    for (const action of pressed) if (!this.#pressed.has(action)) this.#act(action, true);
    for (const action of this.#pressed) if (!pressed.has(action)) this.#act(action, false);
    this.#pressed = pressed;
    const names = new Set([...Object.keys(axes), ...Object.keys(this.axes)]);
    const isChanged = [...names].some(
      (axis) =>
        Math.abs((axes[axis] ?? 0) - (this.axes[axis] ?? 0)) > 0.02 ||
        ((axes[axis] ?? 0) === 0) !== ((this.axes[axis] ?? 0) === 0),
    );
    if (isChanged) this.axes = axes;
    return isChanged;
  }

  addTo(axes) {
    for (const [axis, value] of Object.entries(this.axes)) axes[axis] += value;
  }
}

// A dead zone at rest, fine control near the middle, full effort at the end.
function shaped(value) {
  const size = Math.abs(value);
  return size < DEAD_ZONE ? 0 : Math.sign(value) * ((Math.min(size, 1) - DEAD_ZONE) / (1 - DEAD_ZONE)) ** 1.5;
}
