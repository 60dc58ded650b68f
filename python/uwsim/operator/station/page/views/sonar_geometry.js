// The geometry and colours of a sonar's picture. Bearings are in radians, positive to starboard.

import { SONAR_COLOURS, SONAR_SPAN_DB } from '../wire/messages.js';

// The colours in which the server draws, from the weakest to the strongest level, and others.
export const PALETTES = {
  amber: SONAR_COLOURS,
  grey: ['#000000', '#404040', '#808080', '#c0c0c0', '#ffffff'],
  green: ['#000000', '#06370d', '#118a2b', '#63dd6f', '#eaffe9'],
  ice: ['#000008', '#0b2c5c', '#1f78b4', '#7fd0e8', '#ffffff'],
};
const STEPS = [0.5, 1, 2, 5, 10, 20, 25, 50, 100, 200, 500];
const RINGS = 6;

// The distance between range rings, of at most RINGS up to a reach in any unit of length.
export const ringStep = (reach) => STEPS.find((step) => reach / step <= RINGS) ?? reach;

// The selectable ranges of a sonar with maximum range reach_m: all, half, a quarter ..., at least about 2 m.
export function reaches(reach_m) {
  const found = [reach_m];
  while (found[0] >= 4) found.unshift(found[0] / 2);
  return found;
}

// A fan with its apex below (or above, for one that looks down), as large as it fits into width x height.
export class Fan {
  constructor({ reach_m, half_rad, shown_m = reach_m, width, height, margin, isDown = false }) {
    this.reach_m = reach_m;
    this.half_rad = half_rad;
    this.shown_m = shown_m;
    this.isDown = isDown;
    const [side, back] = this.#bounds(shown_m);
    this.scale = Math.max(Math.min((height - 2 * margin) / (shown_m - back), (width / 2 - margin) / side), 1e-6);
    /** @type {[number, number]} */
    this.apex = [width / 2, isDown ? margin - back * this.scale : height - margin + back * this.scale];
  }

  /** @returns {[number, number]} */
  at(range_m, bearing_rad) {
    const [x, y] = this.apex;
    const ahead = range_m * this.scale * Math.cos(bearing_rad);
    return [x + range_m * this.scale * Math.sin(bearing_rad), this.isDown ? y + ahead : y - ahead];
  }

  // The range and bearing of a pixel; null outside the fan.
  read(x, y) {
    const aside = x - this.apex[0];
    const ahead = this.isDown ? y - this.apex[1] : this.apex[1] - y;
    const range_m = Math.hypot(aside, ahead) / this.scale;
    const bearing_rad = Math.atan2(aside, ahead);
    return range_m <= this.shown_m && Math.abs(bearing_rad) <= this.half_rad + 1e-9 ? { range_m, bearing_rad } : null;
  }

  /** The position of the server's picture, which shows the whole range: x, y, width, height.
   * @returns {[number, number, number, number]}
   */
  get picture() {
    const [side, back] = this.#bounds(this.reach_m);
    const [x, y] = this.apex;
    const top = this.isDown ? y + back * this.scale : y - this.reach_m * this.scale;
    return [x - side * this.scale, top, 2 * side * this.scale, (this.reach_m - back) * this.scale];
  }

  // The path of an arc at a range, or, closed, of the sector up to it.
  trace(path, range_m, isSector = false) {
    const middle = this.isDown ? Math.PI / 2 : -Math.PI / 2;
    path.beginPath();
    if (isSector) path.moveTo(...this.apex);
    path.arc(...this.apex, range_m * this.scale, middle - this.half_rad, middle + this.half_rad);
    if (isSector) path.closePath();
  }

  // Half the width of a fan of this range, and how far it extends behind its apex (not above 0), as in pixels.py.
  #bounds(range_m) {
    const side = range_m * (this.half_rad < Math.PI / 2 ? Math.sin(this.half_rad) : 1);
    return [side, Math.min(range_m * Math.cos(this.half_rad), 0)];
  }
}

// A side-scan's waterfall: range to either side of the middle, the newest line at the top.
export class Waterfall {
  constructor({ reach_m, shown_m = reach_m, width, height }) {
    this.reach_m = reach_m;
    this.shown_m = shown_m;
    this.width = width;
    this.height = height;
    this.scale = width / 2 / shown_m;
  }

  read(x, y) {
    if (y < 0 || y > this.height || x < 0 || x > this.width) return null;
    const aside_m = (x - this.width / 2) / this.scale;
    return { range_m: Math.abs(aside_m), bearing_rad: Math.sign(aside_m) * (Math.PI / 2) };
  }

  /** @returns {[number, number, number, number]} */
  get picture() {
    return [this.width / 2 - this.reach_m * this.scale, 0, 2 * this.reach_m * this.scale, this.height];
  }
}

// Return a function that recolours RGBA pixels of the server's picture in place. gain_db: raises all levels.
export function recolouring(name, gain_db) {
  const levels = levelOfBrightness();
  const table = Array.from({ length: levels.length }, (_, sum) =>
    colourAt(PALETTES[name], Math.min(Math.max(levels[sum] + gain_db / SONAR_SPAN_DB, 0), 1)),
  );
  return (pixels) => {
    for (let k = 0; k < pixels.length; k += 4) {
      [pixels[k], pixels[k + 1], pixels[k + 2]] = table[pixels[k] + pixels[k + 1] + pixels[k + 2]];
    }
  };
}

// The level, 0..1, by the sum of red, green and blue in the server's colours, which increases with the level.
function levelOfBrightness() {
  const found = new Float64Array(766);
  let level = 0;
  for (let sum = 0; sum < found.length; sum += 1) {
    while (level < 1 && total(colourAt(PALETTES.amber, level)) < sum) level += 1 / 512;
    found[sum] = Math.min(level, 1);
  }
  return found;
}

const total = (colour) => colour[0] + colour[1] + colour[2];

function colourAt(anchors, level) {
  const at = level * (anchors.length - 1);
  const k = Math.min(Math.floor(at), anchors.length - 2);
  const [low, high] = [rgb(anchors[k]), rgb(anchors[k + 1])];
  return low.map((value, i) => Math.round(value + (at - k) * (high[i] - value)));
}

const rgb = (hex) => [1, 3, 5].map((from) => parseInt(hex.slice(from, from + 2), 16));
