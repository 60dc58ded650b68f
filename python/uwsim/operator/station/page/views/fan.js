// The newest ping of the multibeam in the plane of its fan: the sonar is below, up is ahead, right is starboard.
import { el, pen } from '../dom.js';
import { inUnit, unit, unitName } from '../units.js';
import { Fan, ringStep } from './sonar_geometry.js';
import { SonarTools } from './sonar_tools.js';

const INK = '#c9d8e2';
const SOFT = 'rgb(150 178 194 / .55)';
const WATER = 'rgb(38 132 148 / .22)';
const ECHO = '#ffd166';
const OLD = 'rgb(255 209 102 / .16)';
const MEMORY = 12; // pings that remain visible as an afterglow
const CURSOR = '#6ee0ec';
const REACHES = [3, 5, 10, 20, 30, 50, 100];

export class FanView {
  name = 'fan';
  kind = 'fan';
  title = 'Sonar';
  /** @type {{ angle_min: number, angle_max: number, angle_increment: number, ranges: ArrayLike<number>, range_max: number } | null} */
  #scan = null;
  #old = [];
  #isLarge = false;
  /** @type {Fan | null} */
  shown = null; // the geometry last drawn

  constructor() {
    this.canvas = el('canvas', { role: 'img', 'aria-label': 'Ranges of the newest sonar ping' });
    this.tools = new SonarTools(this.canvas, { ranges: [0, ...REACHES], hasLevels: false });
    this.element = [this.canvas, this.tools.element, this.tools.frozen];
    this.tools.addEventListener('change', () => this.#draw());
    new ResizeObserver(() => this.#draw()).observe(this.canvas);
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    if (!isLarge) this.tools.freeze(false);
    this.#draw();
  }

  clear() {
    this.#scan = null;
    this.#old = [];
    this.#draw();
  }

  show(scan) {
    if (this.tools.isFrozen) return;
    if (this.#scan) this.#old = [...this.#old.slice(-MEMORY), this.#scan];
    this.#scan = scan;
    if (!document.hidden) this.#draw();
  }

  #draw() {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const c = pen(canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = '#07131a';
    c.fillRect(0, 0, width, height);
    if (!this.#scan) return;
    const { angle_min: least, angle_max: most } = this.#scan;
    const reach = (this.#isLarge && this.tools.reach_m) || shownReach(this.#scan);
    const half_rad = Math.min(Math.max(Math.abs(least), Math.abs(most)), Math.PI / 2);
    const shown = new Fan({ reach_m: reach, half_rad, width, height, margin: this.#isLarge ? 34 : 6 });
    this.shown = shown;
    const at = (range, angle) => shown.at(range, -angle); // a scan's angles increase to port
    this.#rings(c, shown);
    c.save();
    shown.trace(c, reach, true); // echoes may lie beyond the range shown
    c.clip();
    for (const scan of this.#old) this.#echoes(c, at, scan, OLD, this.#isLarge ? 2 : 1);
    this.#water(c, at, this.#scan);
    this.#echoes(c, at, this.#scan, ECHO, this.#isLarge ? 3 : 1.6);
    c.restore();
    if (this.#isLarge) this.#cursor(c, shown);
  }

  /** @param {CanvasRenderingContext2D} c
   * @param {Fan} shown
   */
  #cursor(c, shown) {
    const found = this.tools.at && shown.read(...this.tools.at);
    this.tools.read(found);
    if (!found) return;
    c.strokeStyle = CURSOR;
    shown.trace(c, found.range_m);
    c.moveTo(...shown.apex);
    c.lineTo(...shown.at(shown.shown_m, found.bearing_rad));
    c.stroke();
  }

  /** @param {CanvasRenderingContext2D} c
   * @param {Fan} shown
   */
  #rings(c, shown) {
    c.strokeStyle = SOFT;
    c.fillStyle = INK;
    c.lineWidth = 1;
    c.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    c.textBaseline = 'middle';
    const reach = inUnit(shown.shown_m);
    const step = ringStep(reach);
    for (const range of [...Array.from({ length: Math.floor(reach / step) }, (_, k) => (k + 1) * step), reach]) {
      const range_m = range / inUnit(1, unit());
      shown.trace(c, range_m);
      c.stroke();
      if (!this.#isLarge || (range === reach && reach % step !== 0 && reach % step < 0.4 * step)) continue;
      const [x, y] = shown.at(range_m, shown.half_rad);
      c.fillText(`${+range.toFixed(1)} ${unitName()}`, x + 8, y);
    }
    const thirds = this.#isLarge ? [-1, -2 / 3, -1 / 3, 0, 1 / 3, 2 / 3, 1] : [-1, 0, 1];
    for (const share of thirds) {
      c.beginPath();
      c.moveTo(...shown.apex);
      c.lineTo(...shown.at(shown.shown_m, share * shown.half_rad));
      c.stroke();
    }
    if (!this.#isLarge) return;
    c.textAlign = 'center';
    for (const share of thirds) {
      const degrees = Math.round((Math.abs(share) * shown.half_rad * 180) / Math.PI);
      const side = Math.abs(share) < 1 ? '' : ` ${share < 0 ? 'port' : 'starboard'}`;
      const [x, y] = shown.at(shown.shown_m, share * shown.half_rad);
      c.fillText(`${degrees}°${side}`, x + (side ? Math.sign(share) * 18 : 0), y - (side ? 18 : 14));
    }
    c.textAlign = 'left';
  }

  // The water through which the ping has passed without an echo.
  #water(c, at, { ranges, angle_min, angle_increment, range_max }) {
    // clipped to the range shown
    c.beginPath();
    c.moveTo(...at(0, 0));
    ranges.forEach((range, k) =>
      c.lineTo(...at(isEcho(range) ? range : 2 * range_max, angle_min + k * angle_increment)),
    );
    c.closePath();
    c.fillStyle = WATER;
    c.fill();
  }

  #echoes(c, at, { ranges, angle_min, angle_increment }, colour, size) {
    c.fillStyle = colour;
    ranges.forEach((range, k) => {
      if (!isEcho(range)) return;
      const [x, y] = at(range, angle_min + k * angle_increment);
      c.fillRect(x - size / 2, y - size / 2, size, size);
    });
  }
}

// Return the smallest of REACHES that shows all echoes, so that near ones are drawn large.
function shownReach({ ranges, range_max }) {
  const farthest = ranges.reduce((most, range) => (isEcho(range) && range > most ? range : most), 0);
  if (farthest === 0) return range_max;
  return Math.min(range_max, REACHES.find((reach) => reach > 1.1 * farthest) ?? range_max);
}

const isEcho = (range) => Number.isFinite(range) && range > 0;
