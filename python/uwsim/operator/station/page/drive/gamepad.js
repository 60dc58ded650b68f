// The connected gamepads: their sticks as efforts, their buttons as actions.
import { ALL_STOP } from './bindings.js';
import { Arming, Profiles, readPad } from './pads.js';

/** @returns {Gamepad[]} */
export const connectedPads = () =>
  [...(navigator.getGamepads?.() ?? [])].flatMap((pad) => (pad?.connected ? [pad] : []));

export class Gamepads {
  #pressed = new Set();
  #armings = new Map(); // by the pads' index
  #act;
  #notice;
  #noticed = new Map();
  profiles = new Profiles();
  axes = {};

  // notice(text): shows a pad's state to the pilot.
  constructor(act, notice) {
    [this.#act, this.#notice] = [act, notice];
  }

  // 'unknown', 'centre' (its sticks must be released first) or 'armed'.
  stateOf(pad) {
    if (Object.keys(this.profiles.of(pad).sticks).length === 0) return 'unknown';
    return this.#armings.get(pad.index)?.isArmed ? 'armed' : 'centre';
  }

  // From now on each pad must be centred before it drives.
  disarm() {
    this.axes = {};
    for (const arming of this.#armings.values()) arming.disarm();
  }

  // Read all gamepads; called once per frame. Return whether an axis has changed.
  poll(isAllowed) {
    const pads = connectedPads();
    const axes = {};
    const pressed = new Set();
    for (const index of this.#armings.keys())
      if (!pads.some((pad) => pad.index === index)) {
        this.#armings.delete(index);
        this.#noticed.delete(index);
      }
    for (const pad of pads) {
      if (!this.#armings.has(pad.index)) this.#armings.set(pad.index, new Arming());
      const { efforts, actions } = readPad(pad, this.profiles.of(pad));
      const allowed = this.#armings.get(pad.index).pass(efforts, isAllowed);
      for (const [axis, value] of Object.entries(allowed)) axes[axis] = (axes[axis] ?? 0) + value;
      for (const action of actions) if (isAllowed || action === ALL_STOP) pressed.add(action);
      if (isAllowed) this.#explain(pad);
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

  // Notify the pilot once, after a frame or two, why a pad does not drive.
  #explain(pad) {
    const [last, frames] = this.#noticed.get(pad.index) ?? ['', 0];
    const state = this.stateOf(pad);
    if (state !== last) this.#noticed.set(pad.index, [state, 0]);
    else this.#noticed.set(pad.index, [state, frames + 1]);
    if (frames !== 2 * Arming.LOOKS || state !== last) return;
    const name = pad.id.replace(/ \(.*/, '').slice(0, 30);
    if (state === 'unknown') this.#notice(`${name}: its layout is unknown. Assign its sticks: menu, Gamepad.`);
    else if (state === 'centre') this.#notice(`${name}: release its sticks, then it can drive.`);
  }
}
