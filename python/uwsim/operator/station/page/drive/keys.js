// Converts held or counted keys to efforts, and pressed keys to actions.
import { ALL_STOP, DRIVING } from './bindings.js';

const TYPING = 'input, select, textarea, [contenteditable]';
const axisOf = (action) => action.slice(0, -1);
const signOf = (action) => (action.endsWith('+') ? 1 : -1);

export class Keys {
  #held = new Map(); // key's code: control action
  #sums = {}; // axis: sum of its presses, where keys add up
  #bindings;
  #act;
  #changed;
  #allowed;

  // act(action, isPressed): an action that is not an axis. changed(): held keys changed. allowed(): may the keys drive?
  constructor(bindings, { act, changed, allowed }) {
    [this.#bindings, this.#act, this.#changed, this.#allowed] = [bindings, act, changed, allowed];
    addEventListener('keydown', (event) => this.#down(event));
    addEventListener('keyup', (event) => this.#up(event));
  }

  get isHeld() {
    return this.#held.size > 0 || Object.values(this.#sums).some(Boolean);
  }

  get actions() {
    return new Set(this.#held.values());
  }

  // Release all keys and forget their sums: each must be pressed again.
  drop() {
    const had = this.isHeld;
    this.#held.clear();
    this.#sums = {};
    if (had) this.#changed();
  }

  // Add the efforts of the keys to the axes.
  addTo(axes) {
    for (const action of this.#held.values()) axes[axisOf(action)] += signOf(action);
    for (const [axis, sum] of Object.entries(this.#sums)) axes[axis] += sum;
  }

  #down(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.(TYPING)) return;
    const action = this.#bindings.actionOf(event.code);
    if (!action || (action !== ALL_STOP && !this.#allowed())) return;
    if (event.target.matches?.('canvas') && event.code.startsWith('Arrow')) return; // the arrows turn the 3D view
    const isButton = event.target.closest?.('button, a, summary');
    if (isButton && event.code === 'Space' && event.target.matches(':focus-visible')) return; // presses the button
    event.preventDefault();
    if (event.repeat) return;
    if (action in DRIVING) {
      if (this.#bindings.addsUp) this.#add(action);
      else this.#held.set(event.code, action);
      this.#changed();
    } else {
      this.#act(action, true);
    }
  }

  #add(action) {
    const axis = axisOf(action);
    this.#sums[axis] = Math.max(-1, Math.min(1, (this.#sums[axis] ?? 0) + signOf(action)));
  }

  #up(event) {
    if (this.#held.delete(event.code)) {
      this.#changed();
    } else if (this.#allowed()) {
      const action = this.#bindings.actionOf(event.code);
      if (action && !(action in DRIVING)) this.#act(action, false);
    }
  }
}
