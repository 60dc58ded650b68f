// The picture of an imaging sonar, recoloured and enlarged as the pilot chooses, with range rings and bearings.
import { el, pen } from '../dom.js';
import { inUnit, unit, unitName } from '../units.js';
import { Fan, reaches, recolouring, ringStep, Waterfall } from './sonar_geometry.js';
import { bearingText, SonarTools } from './sonar_tools.js';

const LINE = 'rgb(225 240 248 / .6)';
const INK = '#dfe8ee';
const HALO = 'rgb(0 0 0 / .75)';
const CURSOR = '#6ee0ec';
const BEARINGS_DEG = [10, 15, 30, 45]; // between bearing lines
const LINES = 6;

export class SonarScreen {
  #isLarge = false;
  /** @type {{ raw: ImageData, width: number, height: number, canvas: OffscreenCanvas } | null} */
  #colours = null; // the picture as received, recoloured
  #last = '';
  /** @type {Fan | Waterfall | null} */
  shown = null; // the geometry last drawn, for tests

  // sonar: { shape, range_m, fov_rad } of the view's description.
  constructor(sonar) {
    this.sonar = sonar;
    this.source = document.createElement('canvas'); // of a Picture, which draws what it receives here
    this.canvas = el('canvas', { className: 'picture' });
    this.tools = new SonarTools(this.canvas, { ranges: reaches(sonar.range_m), hasLevels: true });
    this.element = [this.canvas, this.tools.element, this.tools.frozen];
    this.tools.addEventListener('change', () => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    if (!isLarge) this.tools.freeze(false); // a small view must never show an old picture unnoticed
    this.draw();
  }

  // A new picture is in the source.
  show() {
    if (!this.tools.isFrozen) this.#recolour(true);
    this.draw();
  }

  #recolour(isNew) {
    const { palette, gain_db } = this.tools;
    const wanted = `${palette} ${gain_db}`;
    if (!isNew && wanted === this.#last) return;
    if (isNew || !this.#colours) {
      const { width, height } = this.source;
      const raw = pen(this.source).getImageData(0, 0, width, height);
      this.#colours = { raw, width, height, canvas: new OffscreenCanvas(width, height) };
    }
    this.#last = wanted;
    const { raw, width, height, canvas } = this.#colours;
    const pixels = new ImageData(new Uint8ClampedArray(raw.data), width, height);
    recolouring(palette, gain_db)(pixels.data);
    pen(canvas).putImageData(pixels, 0, 0);
  }

  draw() {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const c = pen(canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = '#05080a';
    c.fillRect(0, 0, width, height);
    if (!this.#colours) return;
    this.#recolour(false);
    const { range_m: reach_m, fov_rad, shape } = this.sonar;
    const size = { reach_m, shown_m: this.#isLarge ? this.tools.reach_m : reach_m, width, height };
    const shown =
      shape === 'waterfall'
        ? new Waterfall(size)
        : new Fan({ ...size, half_rad: fov_rad / 2, margin: this.#isLarge ? 58 : 4, isDown: shape === 'fan_down' });
    this.shown = shown;
    c.save();
    if (shown instanceof Fan) {
      shown.trace(c, shown.shown_m, true);
      c.clip();
    }
    c.drawImage(this.#colours.canvas, ...shown.picture);
    c.restore();
    if (!this.#isLarge) return;
    c.strokeStyle = LINE;
    c.lineWidth = 1;
    c.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    c.textBaseline = 'middle';
    if (shown instanceof Fan) this.#fanLines(c, shown);
    else this.#waterfallLines(c, shown);
    this.#cursor(c, shown);
  }

  /** The ranges of the rings, in metres, with their labels.
   * @param {Fan | Waterfall} shown
   * @returns {[number, string][]}
   */
  #rings(shown) {
    const reach = inUnit(shown.shown_m);
    const step = ringStep(reach);
    return Array.from({ length: Math.floor(reach / step + 1e-9) }, (_, k) => {
      const range = (k + 1) * step;
      return [range / inUnit(1, unit()), `${+range.toFixed(1)} ${unitName()}`];
    });
  }

  /** @param {CanvasRenderingContext2D} c
   * @param {Fan} shown
   */
  #fanLines(c, shown) {
    for (const [range_m, text] of this.#rings(shown)) {
      shown.trace(c, range_m);
      c.stroke();
      const [x, y] = shown.at(range_m, shown.half_rad);
      label(c, text, x + 6, shown.isDown ? y - 10 : y, 'left');
    }
    const half_deg = (shown.half_rad * 180) / Math.PI;
    const step = BEARINGS_DEG.find((degrees) => half_deg / degrees <= LINES / 2 + 1) ?? half_deg;
    const count = Math.floor(half_deg / step + 1e-9);
    for (let k = -count; k <= count; k += 1) {
      const bearing_rad = (k * step * Math.PI) / 180;
      c.beginPath();
      c.moveTo(...shown.apex);
      c.lineTo(...shown.at(shown.shown_m, bearing_rad));
      c.stroke();
      const [x, y] = shown.at(shown.shown_m + 14 / shown.scale, bearing_rad);
      label(c, `${Math.abs(k * step)}°`, x, y, 'center');
    }
  }

  /** @param {CanvasRenderingContext2D} c
   * @param {Waterfall} shown
   */
  #waterfallLines(c, shown) {
    const { width, height, scale } = shown;
    for (const [range_m, text] of this.#rings(shown)) {
      for (const side of [-1, 1]) {
        const x = width / 2 + side * range_m * scale;
        c.beginPath();
        c.moveTo(x, 0);
        c.lineTo(x, height);
        c.stroke();
        label(c, text, x - side * 4, height / 2, side < 0 ? 'left' : 'right');
      }
    }
    label(c, bearingText(-Math.PI / 2), 10, 60, 'left');
    label(c, bearingText(Math.PI / 2), width - 10, 60, 'right');
  }

  /** @param {CanvasRenderingContext2D} c
   * @param {Fan | Waterfall} shown
   */
  #cursor(c, shown) {
    const { at } = this.tools;
    const found = at && shown.read(at[0], at[1]);
    this.tools.read(found);
    if (!found) return;
    c.strokeStyle = CURSOR;
    if (shown instanceof Fan) {
      shown.trace(c, found.range_m);
      c.stroke();
      c.beginPath();
      c.moveTo(...shown.apex);
      c.lineTo(...shown.at(shown.shown_m, found.bearing_rad));
    } else {
      c.beginPath();
      c.moveTo(at[0], 0);
      c.lineTo(at[0], shown.height);
      c.moveTo(0, at[1]);
      c.lineTo(shown.width, at[1]);
    }
    c.stroke();
  }
}

// Text with a dark edge, so that it can be read over any echo.
function label(c, text, x, y, align) {
  c.save();
  c.textAlign = align;
  c.strokeStyle = HALO;
  c.lineWidth = 3;
  c.strokeText(text, x, y);
  c.fillStyle = INK;
  c.fillText(text, x, y);
  c.restore();
}
