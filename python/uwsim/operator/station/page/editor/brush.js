// The editor's brush, which draws on the bed of the chart: it raises, lowers or smooths along the pointer's way.
import { capital, el } from '../dom.js';

const WAYS = ['', 'raise', 'lower', 'smooth'];
const POINTS_MAX = 200; // of a stroke, as in the scenario's schema
const STEP = 0.25; // of the width, between points
const WIDER = 1.25;

const number = (name, value) =>
  el('input', { type: 'number', min: '0.1', max: '1000', step: 'any', value, 'aria-label': name, title: name });

export class Brush {
  /** @type {[number, number][]} */
  line = []; // of the stroke that is being drawn

  constructor() {
    this.way = el(
      'select',
      {
        'aria-label': 'Brush',
        title: 'B: the next brush; [ and ]: narrower, wider. Drag on the chart to draw on the bed',
        onchange: () => this.#show(),
      },
      ...WAYS.map((each) => el('option', { value: each }, each ? capital(each) : 'Brush')),
    );
    this.width = number('Width of the brush [m]', '10');
    this.height = number('Height of a stroke [m]', '2');
    this.element = el('span', { className: 'editor-brush' }, this.way, this.width, this.height);
    this.#show();
  }

  get isOn() {
    return this.way.value !== '';
  }

  get width_m() {
    return Number(this.width.value);
  }

  // The fields of a stroke along a line.
  stroke(line_m) {
    const values = { line_m, width_m: this.width_m };
    if (this.way.value === 'smooth') return { ...values, height_m: 0, smooth: 1 };
    return { ...values, height_m: (this.way.value === 'lower' ? -1 : 1) * Number(this.height.value) };
  }

  // Take up the next brush; after the last, none.
  next() {
    this.way.selectedIndex = (this.way.selectedIndex + 1) % WAYS.length;
    this.#show();
  }

  widen(isWider) {
    this.width.value = String(Number((this.width_m * (isWider ? WIDER : 1 / WIDER)).toPrecision(3)));
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

  #show() {
    this.width.hidden = !this.isOn;
    this.height.hidden = !this.isOn || this.way.value === 'smooth';
  }
}
