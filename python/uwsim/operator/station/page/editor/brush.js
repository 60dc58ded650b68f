// The editor's brush, which draws on the bed of the chart: it raises, lowers or smooths along the pointer's way.
import { signal } from '../vendor/preact.js';

export const WAYS = ['', 'raise', 'lower', 'smooth'];
const POINTS_MAX = 200; // of a stroke, as in the scenario's schema
const STEP = 0.25; // of the width, between points
const WIDER = 1.25;

export class Brush {
  #now = signal({ way: '', width_m: 10, height_m: 2 });
  /** @type {[number, number][]} */
  line = []; // of the stroke that is being drawn

  take(changes) {
    this.#now.value = { ...this.#now.value, ...changes };
  }

  get way() {
    return this.#now.value.way;
  }

  get isOn() {
    return this.way !== '';
  }

  get width_m() {
    return this.#now.value.width_m;
  }

  get height_m() {
    return this.#now.value.height_m;
  }

  // The fields of a stroke along a line.
  stroke(line_m) {
    const { way, width_m, height_m } = this;
    if (way === 'smooth') return { line_m, width_m, height_m: 0, smooth: 1 };
    return { line_m, width_m, height_m: (way === 'lower' ? -1 : 1) * height_m };
  }

  // Take up the next brush; after the last, none.
  next() {
    this.take({ way: WAYS[(WAYS.indexOf(this.way) + 1) % WAYS.length] });
  }

  widen(isWider) {
    this.take({ width_m: Number((this.width_m * (isWider ? WIDER : 1 / WIDER)).toPrecision(3)) });
  }

  // Go on to a place; the line keeps points that are far enough apart.
  to([x, y]) {
    const last = this.line.at(-1);
    const isFar = !last || Math.hypot(last[0] - x, last[1] - y) >= Math.max(STEP * this.width_m, 0.1);
    if (isFar && this.line.length < POINTS_MAX) this.line.push([Math.round(x * 10) / 10, Math.round(y * 10) / 10]);
  }

  // End the stroke; return its line.
  end() {
    const { line } = this;
    this.line = [];
    return line;
  }
}
