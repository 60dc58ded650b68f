// The newest ping of the multibeam in the plane of its fan: the sonar is below, up is ahead, right is starboard.
import { el } from '../dom.js';

const INK = '#c9d8e2';
const SOFT = 'rgb(150 178 194 / .55)';
const WATER = 'rgb(38 132 148 / .22)';
const ECHO = '#ffd166';
const OLD = 'rgb(255 209 102 / .16)';
const MEMORY = 12; // pings that remain visible as an afterglow
const RINGS = 5;
const REACHES = [3, 5, 10, 20, 30, 50, 100];

export class FanView {
  name = 'fan';
  kind = 'fan';
  title = 'Sonar';
  #scan = null;
  #old = [];
  #isLarge = false;

  constructor() {
    this.canvas = el('canvas', { role: 'img', 'aria-label': 'Ranges of the newest sonar ping' });
    this.element = [this.canvas];
    new ResizeObserver(() => this.#draw()).observe(this.canvas);
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    this.#draw();
  }

  clear() {
    this.#scan = null;
    this.#old = [];
    this.#draw();
  }

  take(scan) {
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
    const c = canvas.getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = '#07131a';
    c.fillRect(0, 0, width, height);
    if (!this.#scan) return;
    const { angle_min: least, angle_max: most } = this.#scan;
    const reach = shownReach(this.#scan);
    const half = Math.min(Math.max(Math.abs(least), Math.abs(most)), Math.PI / 2);
    const margin = this.#isLarge ? 34 : 6;
    const scale = Math.min((height - 2 * margin) / reach, (width / 2 - margin) / (reach * Math.sin(half)));
    const at = (range, angle) => [
      width / 2 - range * scale * Math.sin(angle),
      height - margin - range * scale * Math.cos(angle),
    ];
    this.#rings(c, at, scale, [width / 2, height - margin], half, reach);
    c.save();
    c.beginPath(); // older echoes may lie beyond the range shown
    c.moveTo(width / 2, height - margin);
    c.arc(width / 2, height - margin, reach * scale, -Math.PI / 2 - half, -Math.PI / 2 + half);
    c.clip();
    for (const scan of this.#old) this.#echoes(c, at, scan, OLD, this.#isLarge ? 2 : 1);
    this.#water(c, at, this.#scan);
    c.restore();
    this.#echoes(c, at, this.#scan, ECHO, this.#isLarge ? 3 : 1.6);
  }

  #rings(c, at, scale, [x, y], half, reach) {
    c.strokeStyle = SOFT;
    c.fillStyle = INK;
    c.lineWidth = 1;
    c.font = `11px ${getComputedStyle(document.body).fontFamily}`;
    c.textBaseline = 'middle';
    const step = [0.5, 1, 2, 5, 10, 20, 25, 50, 100].find((metres) => reach / metres <= RINGS + 1) ?? reach;
    for (const range of [...Array.from({ length: Math.floor(reach / step) }, (_, k) => (k + 1) * step), reach]) {
      c.beginPath();
      c.arc(x, y, range * scale, -Math.PI / 2 - half, -Math.PI / 2 + half);
      c.stroke();
      if (!this.#isLarge || (range === reach && reach % step !== 0 && reach % step < 0.4 * step)) continue;
      const [left, top] = at(range, -half);
      c.fillText(`${+range.toFixed(1)} m`, left + 8, top);
    }
    c.beginPath();
    for (const angle of [-half, 0, half]) {
      c.moveTo(x, y);
      c.lineTo(...at(reach, angle));
    }
    c.stroke();
    if (!this.#isLarge) return;
    c.textAlign = 'center';
    c.fillText('port', at(reach, half)[0] - 14, at(reach, half)[1] - 18);
    c.fillText('starboard', at(reach, -half)[0] + 22, at(reach, -half)[1] - 18);
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
