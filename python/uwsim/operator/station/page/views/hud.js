// The head-up display: heading, depth, altitude and attitude over the video, for a pilot who looks only at the picture.
import { pen } from '../dom.js';
import { attitude } from '../attitude.js';
import { shownHolds } from '../drive/holds.js';
import { inUnit, unitName } from '../units.js';
import { axisText, pixelsBelow } from './camera_axis.js';
import { GAUGES } from '../wire/messages.js';

const CARDINALS = { 0: 'N', 45: 'NE', 90: 'E', 135: 'SE', 180: 'S', 225: 'SW', 270: 'W', 315: 'NW' };

const TAPES = GAUGES.filter(({ list }) => list === 'big'); // depth to the left, altitude to the right
const INK = '#f2f8fb';
const SOFT = 'rgb(242 248 251 / .72)';
const STALE = '#9aa6ae';
const SHADE = 'rgb(5 10 13 / .62)';
const WARN = '#ffc247';
const STEEPEST = 70; // elevation of a camera's axis [deg] beyond which no horizon is drawn
const HELD = '#7be0a2';
const RADIUS = 92; // of the ladder
const HEADING = 64; // height of the heading's tape and value
const LINES = 92; // height of the lines at the foot
const CONTACT = 28; // height of the line about what is near
const [ABOVE, BELOW] = [HEADING + CONTACT + RADIUS + 8, RADIUS - 8 + LINES]; // heights above and below the middle

export class Hud {
  /** What was drawn last: the camera's axis, the contact, the value on each tape, and each part's left and upper edge,
   * width and height on the canvas [px].
   * @type {{ axis: object | null, contact: object | null, tapes: Record<string, number>,
   *   boxes: Record<string, [number, number, number, number]> } | null}
   */
  shown = null;

  ink = INK;
  soft = SOFT;

  constructor(canvas) {
    this.canvas = canvas;
    this.context = pen(canvas);
  }

  clear() {
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
  }

  // axis: see cameraAxis; null if the camera's angles are unknown. focal: in pixels per picture width. isFilled: whether
  // the picture fills the canvas and is cut, or is shown whole. covered: see handheld.js. contact: see Telemetry. arm: see
  // ArmDrive.
  draw(message, { isStale, axis, focal, aspect, isFilled, covered, proximity_m, contact, arm }) {
    this.shown = { axis, contact, tapes: {}, boxes: {} };
    const { canvas, context: c } = this;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    if (!message || width < 240) return;
    const wide = (isFilled ? Math.max : Math.min)(width, height * aspect); // of the picture
    const left = Math.max(0, (width - wide) / 2);
    const rem_px = parseFloat(getComputedStyle(document.documentElement).fontSize);
    const letterbox = Math.max(0, (height - wide / aspect) / 2);
    const top = letterbox + covered.head * rem_px;
    const foot = height - letterbox - covered.foot * rem_px;
    const [above, below] = [(height / 2 - top - 10) / ABOVE, (foot - height / 2) / BELOW]; // where all has its place
    const scale = Math.min(
      (rem_px / 16) * Math.max(0.72, Math.min(1.15, height / 560)),
      Math.max(0.72, Math.min(above, below)),
    );
    this.ink = isStale ? STALE : INK;
    this.soft = isStale ? STALE : SOFT;
    c.textBaseline = 'middle';
    const angles = attitude(message.orientation);
    if (axis && Math.abs(axis.up_deg) < STEEPEST) this.#ladder(width / 2, height / 2, scale, axis, focal * wide);
    const camera = axis ? `CAM ${axisText(axis)}` : 'CAM angle unknown';
    this.#plate('camera', camera, width / 2, foot - 30 * scale, 11 * scale, this.ink);
    const aboveLadder = (top + 10 + HEADING * scale + height / 2 - (RADIUS + 8) * scale) / 2;
    if (contact && !isStale) this.#contact(width / 2, aboveLadder, scale, contact);
    const side = left + Math.max(12, width * 0.02);
    const holds = shownHolds(message);
    const target = (name) => holds.find((hold) => hold.name === name)?.target ?? null;
    const inTarget = (name) => (target(name) === null ? null : inUnit(target(name)));
    const yaw_rad = target('heading');
    const broad = Math.min(440, width * 0.46, width - 2 * covered.shoulders * rem_px);
    this.#heading(width / 2, top + 10, broad, scale, angles.heading_deg, {
      target_deg: yaw_rad === null ? null : 90 - (yaw_rad * 180) / Math.PI,
    });
    const free = width - 2 * (side + covered.corners * rem_px);
    this.#chips(
      width / 2,
      foot - 64 * scale,
      scale,
      [...holds, ...arm],
      isStale ? '' : (message.hold_note ?? ''),
      free,
    );
    const clear = 2 * (foot - LINES * scale - height / 2); // of the lines
    const tall = Math.min(300, height * 0.56, height - 2 * covered.corners * rem_px, clear);
    TAPES.forEach(({ name, word = name }, k) => {
      this.#tape(k ? width - side : side, height / 2, tall, scale, {
        name: k ? 'ALT' : 'DEPTH',
        value: inUnit(message[name]),
        target: inTarget(word),
        side: k ? 'right' : 'left',
        down: !k,
        color: k && !isStale && message[name] < proximity_m ? WARN : this.ink,
      });
    });
  }

  #font(size, weight = 500) {
    this.context.font = `${weight} ${size}px ${getComputedStyle(document.body).fontFamily}`;
  }

  #mind(name, x, y, w, h) {
    if (this.shown) this.shown.boxes[name] = [x, y, w, h];
  }

  #box(x, y, w, h) {
    const { context: c } = this;
    c.fillStyle = SHADE;
    c.beginPath();
    c.roundRect(x, y, w, h, 4);
    c.fill();
  }

  #heading(middle, top, width, scale, heading, { target_deg }) {
    const { context: c } = this;
    const height = 34 * scale;
    const perDegree = width / 90;
    this.#box(middle - width / 2, top, width, height);
    c.save();
    c.beginPath();
    c.rect(middle - width / 2, top, width, height);
    c.clip();
    c.strokeStyle = this.soft;
    c.fillStyle = this.ink;
    c.lineWidth = 1;
    c.textAlign = 'center';
    this.#font(11 * scale, 600);
    const first = Math.ceil((heading - 50) / 5) * 5;
    for (let degree = first; degree <= heading + 50; degree += 5) {
      const x = Math.round(middle + (degree - heading) * perDegree) + 0.5;
      const whole = (degree + 360) % 360;
      const isNamed = whole % 15 === 0;
      c.beginPath();
      c.moveTo(x, top + height);
      c.lineTo(x, top + height - (isNamed ? 8 : 4) * scale);
      c.stroke();
      const text = CARDINALS[whole] ?? String(whole).padStart(3, '0');
      const isWhole = Math.abs(x - middle) + c.measureText(text).width / 2 < width / 2;
      if (isNamed && isWhole) c.fillText(text, x, top + 13 * scale);
    }
    if (target_deg !== null) {
      const off_deg = ((((target_deg - heading + 180) % 360) + 360) % 360) - 180;
      const at = middle + Math.max(-44, Math.min(44, off_deg)) * perDegree;
      this.#mark(at, top + height, 0, -1, scale);
    }
    c.restore();
    const [w, h] = [58 * scale, 24 * scale];
    const y = top + height + 3;
    this.#mind('heading', middle - width / 2, top, width, height + 3 + h);
    c.fillStyle = this.ink;
    c.beginPath();
    c.moveTo(middle - 5, y + 1);
    c.lineTo(middle + 5, y + 1);
    c.lineTo(middle, y - 6);
    c.fill();
    this.#box(middle - w / 2, y, w, h);
    c.strokeStyle = this.ink;
    c.strokeRect(middle - w / 2 + 0.5, y + 0.5, w - 1, h - 1);
    c.fillStyle = this.ink;
    c.textAlign = 'center';
    this.#font(15 * scale, 600);
    c.fillText(`${String(Math.round(heading) % 360).padStart(3, '0')}°`, middle, y + h / 2 + 1);
  }

  // Draw a vertical tape with the value in a box at its middle. down: greater values below.
  /** @type {(x: number, middle: number, tall: number, scale: number, values: { name: string, value: number,
   *   side: string, target?: number | null, down?: boolean, color?: string }) => void} */
  #tape(x, middle, tall, scale, { name, value, side, target = null, down = false, color = this.ink }) {
    const { context: c } = this;
    if (this.shown) this.shown.tapes[name] = value;
    const isLeft = side === 'left';
    const wide = 46 * scale;
    const left = isLeft ? x : x - wide;
    const isKnown = Number.isFinite(value);
    const perMetre = tall / 12;
    this.#box(left, middle - tall / 2, wide, tall);
    c.save();
    c.beginPath();
    c.rect(left, middle - tall / 2, wide, tall);
    c.clip();
    c.strokeStyle = this.soft;
    c.fillStyle = this.soft;
    c.lineWidth = 1;
    this.#font(10.5 * scale);
    c.textAlign = isLeft ? 'right' : 'left';
    const edge = isLeft ? left + wide : left;
    const inward = isLeft ? -1 : 1;
    const last = isKnown ? value + 7 : -1;
    for (let tick = Math.ceil(value - 7); tick <= last; tick += 1) {
      if (tick < 0) continue;
      const y = Math.round(middle + (tick - value) * perMetre * (down ? 1 : -1)) + 0.5;
      const isNamed = tick % 2 === 0;
      c.beginPath();
      c.moveTo(edge, y);
      c.lineTo(edge + inward * (isNamed ? 9 : 5) * scale, y);
      c.stroke();
      const away = Math.abs(y - middle); // a name is drawn whole: neither cut by the edge nor below the value
      const isInside = away < tall / 2 - 8 * scale && away > 20 * scale;
      if (isNamed && isInside) c.fillText(String(tick), edge + inward * 13 * scale, y);
    }
    if (target !== null && isKnown) {
      const off = Math.max(-5.8, Math.min(5.8, target - value)) * (down ? 1 : -1);
      this.#mark(edge, middle + off * perMetre, inward, 0, scale);
    }
    c.restore();
    const [w, h] = [66 * scale, 26 * scale];
    const boxLeft = isLeft ? x : x - w;
    c.fillStyle = 'rgb(5 10 13 / .9)';
    c.fillRect(boxLeft, middle - h / 2, w, h);
    c.strokeStyle = color;
    c.strokeRect(boxLeft + 0.5, middle - h / 2 + 0.5, w - 1, h - 1);
    c.fillStyle = color;
    c.textAlign = 'right';
    this.#font(15 * scale, 600);
    c.fillText(isKnown ? value.toFixed(value < 99.95 ? 1 : 0) : '–', boxLeft + w - 17 * scale, middle + 1);
    this.#font(10.5 * scale);
    c.fillText(unitName(), boxLeft + w - 6 * scale, middle + 2);
    c.textAlign = isLeft ? 'left' : 'right';
    this.#font(10.5 * scale, 600);
    this.#outlined(name, x + (isLeft ? 2 : -2), middle - tall / 2 - 9 * scale, color);
    const broad = Math.max(w, c.measureText(name).width + 2);
    this.#mind(side, isLeft ? x : x - broad, middle - tall / 2 - 16 * scale, broad, tall + 16 * scale);
  }

  // A triangle that points at the target of a hold, at the edge of a tape.
  #mark(x, y, right, down, scale) {
    const { context: c } = this;
    const [long, half] = [11 * scale, 7 * scale];
    c.fillStyle = HELD;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x + right * long - down * half, y + down * long + right * half);
    c.lineTo(x + right * long + down * half, y + down * long - right * half);
    c.fill();
  }

  // The active holds, and why the last one was lost.
  #chips(middle, top, scale, holds, note, free) {
    const { context: c } = this;
    this.#font(12 * scale, 600);
    const texts = holds.map(({ short, text }) => `${short} ${text}`.trim());
    const wide = texts.map((text) => c.measureText(text).width + 14 * scale);
    const all = wide.reduce((sum, each) => sum + each + 5, -5);
    let x = middle - all / 2;
    if (holds.length) this.#mind('holds', x, top, all, 22 * scale);
    c.textAlign = 'left';
    texts.forEach((text, k) => {
      this.#box(x, top, wide[k], 22 * scale);
      c.strokeStyle = c.fillStyle = this.ink === STALE ? STALE : HELD;
      c.strokeRect(x + 0.5, top + 0.5, wide[k] - 1, 22 * scale - 1);
      c.fillText(text, x + 7 * scale, top + 11.5 * scale);
      x += wide[k] + 5;
    });
    if (!note) return;
    c.textAlign = 'center';
    this.#plate('note', note, middle, top - 15 * scale, 12 * scale, WARN, free);
  }

  // widest: room for the text, which is squeezed if it is longer.
  #outlined(text, x, y, color, widest = Infinity) {
    const { context: c } = this;
    const room = Number.isFinite(widest) ? [widest] : [];
    c.lineWidth = 3;
    c.strokeStyle = SHADE;
    c.strokeText(text, x, y, ...room);
    c.fillStyle = color;
    c.fillText(text, x, y, ...room);
    c.lineWidth = 1;
  }

  // A line of text on a plate, to be read over anything.
  #plate(part, text, middle, y, size, color, widest = Infinity) {
    const { context: c } = this;
    this.#font(size, 600);
    c.textAlign = 'center';
    const [wide, high] = [Math.min(c.measureText(text).width + size, widest), 1.6 * size];
    this.#box(middle - wide / 2, y - high / 2, wide, high);
    this.#outlined(text, middle, y, color, wide - size);
    this.#mind(part, middle - wide / 2, y - high / 2, wide, high);
  }

  #contact(middle, y, scale, { name, time_s }) {
    const where = name.replaceAll('_', ' ').toUpperCase();
    this.#plate('contact', `${where} IN ${time_s.toFixed(1)} s`, middle, y, 17 * scale, WARN);
  }

  // Lines at true elevations in the picture, so that the line at 0 coincides with the horizon.
  #ladder(x, y, scale, { up_deg: up, roll_deg: roll }, focal) {
    const { context: c } = this;
    const radius = RADIUS * scale;
    this.#mind('ladder', x - radius - 8 * scale, y - radius - 8 * scale, 2 * radius + 16 * scale, 2 * radius);
    c.save();
    c.translate(x, y);
    this.#rollScale(radius, scale, roll);
    c.save();
    c.beginPath();
    c.arc(0, 0, radius - 8 * scale, 0, 2 * Math.PI);
    c.clip();
    c.rotate((-roll * Math.PI) / 180);
    this.#font(10 * scale, 600);
    c.textAlign = 'left';
    for (let degree = -90; degree <= 90; degree += 10) {
      const at = pixelsBelow(degree, up, focal);
      if (at === null || Math.abs(at) > radius) continue;
      const half = (degree === 0 ? 78 : 26) * scale;
      const gap = degree === 0 ? 22 * scale : 0;
      this.#twice(
        () => {
          c.beginPath();
          if (degree < 0) c.setLineDash([5, 4]);
          for (const sign of gap ? [-1, 1] : [0]) {
            c.moveTo(sign ? sign * gap : -half, at);
            c.lineTo(sign ? sign * half : half, at);
          }
          c.stroke();
          c.setLineDash([]);
        },
        degree === 0 ? 1.6 : 1.1,
      );
      if (degree !== 0) this.#outlined(String(Math.abs(degree)), half + 5, at, this.soft);
    }
    c.restore();
    this.#twice(() => {
      // the vehicle
      c.beginPath();
      c.moveTo(-20 * scale, 0);
      c.lineTo(-8 * scale, 0);
      c.lineTo(0, 7 * scale);
      c.lineTo(8 * scale, 0);
      c.lineTo(20 * scale, 0);
      c.stroke();
    }, 2);
    c.restore();
  }

  #rollScale(radius, scale, roll) {
    const { context: c } = this;
    this.#twice(() => {
      c.beginPath();
      for (const mark of [-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60]) {
        const angle = ((mark - 90) * Math.PI) / 180;
        const long = (mark % 30 === 0 ? 8 : 5) * scale;
        c.moveTo(radius * Math.cos(angle), radius * Math.sin(angle));
        c.lineTo((radius + long) * Math.cos(angle), (radius + long) * Math.sin(angle));
      }
      c.stroke();
    }, 1.1);
    c.save();
    c.rotate((Math.max(-70, Math.min(70, roll)) * Math.PI) / 180);
    c.fillStyle = this.ink;
    c.beginPath();
    c.moveTo(0, -radius + 1);
    c.lineTo(-5 * scale, -radius + 9 * scale);
    c.lineTo(5 * scale, -radius + 9 * scale);
    c.fill();
    c.restore();
  }

  // Draw a light line with a dark edge, which is visible over any water.
  #twice(path, width) {
    const { context: c } = this;
    c.lineWidth = width + 2.2;
    c.strokeStyle = SHADE;
    path();
    c.lineWidth = width;
    c.strokeStyle = this.ink;
    path();
    c.lineWidth = 1;
  }
}
