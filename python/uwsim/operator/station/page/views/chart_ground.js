// The chart's ground in the theme's colours: the bed by depth with contours, and obstacles by name. It is kept as a
// picture, which is drawn again only if the frame, the theme or the bed has changed.
import { pen } from '../dom.js';
import { inUnit } from '../units.js';
import { label } from './chart_marks.js';

const CELLS_MAX = 200; // along an axis, for contours
const STEPS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500]; // between contours, in the pilot's unit
const CONTOURS = 8; // at most, between the surface and the deepest place
const LINE_PX = 14; // of names, and how often one gives way by half of that
const LINES = 8;
const BROAD = 4; // lines of a name
const LABEL_PX = 150; // between two labels of contours

/** @typedef {{ rows: number, columns: number, west_m: number, south_m: number, spacing_m: [number, number] }} Grid
 * @typedef {[number, number, number, number]} Segment
 * @typedef {{ depth: number, segments: Segment[] }} Contour
 */

/** The colours of the theme's chart, from its style.
 * @returns {Record<'deep' | 'shoal' | 'land' | 'ink' | 'halo' | 'line' | 'ground' | 'obstacle' | 'flown' | 'planned', string>}
 */
export function palette() {
  const style = getComputedStyle(document.documentElement);
  const names = ['deep', 'shoal', 'land', 'ink', 'halo', 'line', 'ground', 'obstacle', 'flown', 'planned'];
  return /** @type {any} */ (
    Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--chart-${name}`).trim()]))
  );
}

export class ChartGround {
  #canvas = new OffscreenCanvas(1, 1);
  #key = '';
  #edition = 0; // of the bed and the colours
  /** @type {OffscreenCanvas | null} */
  #bed = null;
  /** @type {Contour[]} */
  contours = [];
  colours = palette();

  /** heights, grid: null before the bed is known.
   * @param {Float32Array | null} heights
   * @param {Grid | null} grid
   * @param {number} surface_m
   * @param {any[]} meshes
   */
  constructor(heights, grid, surface_m, meshes) {
    this.heights = heights;
    this.grid = grid;
    this.surface_m = surface_m;
    this.meshes = meshes;
    this.recolour();
  }

  recolour() {
    this.colours = palette();
    this.#edition += 1;
    if (!this.heights || !this.grid) return;
    this.#bed = coloured(this.heights, this.grid, this.surface_m, this.colours);
    this.contours = contours(this.heights, this.grid, this.surface_m);
  }

  draw(c, frame, ratio, isLarge) {
    const { size, scale, middle } = frame;
    const key = [size, scale, middle, ratio, isLarge, this.#edition].join();
    if (key !== this.#key) this.#paint(frame, ratio, isLarge);
    this.#key = key;
    c.drawImage(this.#canvas, 0, 0, ...size);
  }

  #paint(frame, ratio, isLarge) {
    const [width, height] = frame.size;
    [this.#canvas.width, this.#canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const c = pen(this.#canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = this.colours.ground;
    c.fillRect(0, 0, width, height);
    c.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    if (this.grid) this.#paintBed(c, frame, this.grid, isLarge);
    for (const { outline_m } of this.meshes) this.#paintObstacle(c, frame, outline_m);
    if (isLarge) this.#paintNames(c, frame);
  }

  #paintBed(c, frame, { rows, columns, west_m, south_m, spacing_m }, isLarge) {
    const [x, y] = frame.at([west_m - spacing_m[0] / 2, south_m + (rows - 0.5) * spacing_m[1]]);
    const { scale } = frame;
    if (this.#bed) c.drawImage(this.#bed, x, y, columns * spacing_m[0] * scale, rows * spacing_m[1] * scale);
    c.strokeStyle = this.colours.line;
    c.lineWidth = isLarge ? 1 : 0.6;
    c.beginPath();
    for (const { segments } of this.contours)
      for (const [x0, y0, x1, y1] of segments) {
        c.moveTo(...frame.at([x0, y0]));
        c.lineTo(...frame.at([x1, y1]));
      }
    c.stroke();
    if (isLarge) this.#paintDepths(c, frame);
  }

  // The depths of contours, each where no other label is near.
  #paintDepths(c, frame) {
    const [width, height] = frame.size;
    /** @type {[number, number][]} */
    const taken = [];
    for (const { depth, segments } of this.contours)
      for (const [x0, y0] of segments) {
        const [x, y] = frame.at([x0, y0]);
        const isInside = x > 20 && y > 60 && x < width - 20 && y < height - 40;
        if (!isInside || taken.some(([a, b]) => Math.hypot(a - x, b - y) < LABEL_PX)) continue;
        taken.push([x, y]);
        label(c, String(depth), x, y, this.colours);
      }
  }

  #paintObstacle(c, frame, outline) {
    c.beginPath();
    outline.forEach((point, k) => (k ? c.lineTo(...frame.at(point)) : c.moveTo(...frame.at(point))));
    c.closePath();
    c.globalAlpha = 0.3;
    c.fillStyle = c.strokeStyle = this.colours.obstacle;
    c.lineWidth = 1.4;
    c.fill();
    c.globalAlpha = 1;
    c.stroke();
  }

  // The names of obstacles, each below those that it would hide: in the middle, but of a broad one at its north edge, as
  // others may lie in it.
  #paintNames(c, frame) {
    /** @type {[number, number, number][]} */
    const taken = [];
    for (const { name, outline_m: outline } of this.meshes) {
      const text = name.replaceAll('_', ' ');
      const middle = [0, 1].map((axis) => outline.reduce((sum, point) => sum + point[axis], 0) / outline.length);
      const [x, y0] = frame.at(middle);
      const north = northEdge(outline.map((point) => frame.at(point)));
      const top = north === null ? y0 : north + LINE_PX;
      const half = c.measureText(text).width / 2;
      const hides = (y) => taken.some(([a, b, w]) => Math.abs(a - x) < half + w && Math.abs(b - y) < LINE_PX);
      let y = top;
      for (let k = 0; k < LINES && hides(y); k += 1) y += LINE_PX / 2;
      taken.push([x, y, half]);
      label(c, text, x, y, this.colours);
    }
  }
}

// The least y of an outline [px] that fills half of its box and is several lines high; null of others.
function northEdge(points) {
  const [xs, ys] = [0, 1].map((axis) => points.map((point) => point[axis]));
  const [wide, high] = [xs, ys].map((values) => Math.max(...values) - Math.min(...values));
  const twice = points.reduce((sum, [x, y], k) => {
    const [nextX, nextY] = points[(k + 1) % points.length];
    return sum + x * nextY - nextX * y;
  }, 0);
  return high > BROAD * LINE_PX && Math.abs(twice) > wide * high ? Math.min(...ys) : null;
}

// The bed as a picture with one pixel per grid point: the deeper, the nearer to the colour of the deep.
function coloured(heights, { rows, columns }, surface_m, colours) {
  const [deep, shoal, land] = [colours.deep, colours.shoal, colours.land].map(numbers);
  const canvas = new OffscreenCanvas(columns, rows);
  const context = pen(canvas);
  const image = context.createImageData(columns, rows);
  const low_m = lowest(heights);
  for (let j = 0; j < rows; j += 1) {
    for (let i = 0; i < columns; i += 1) {
      const z = heights[(rows - 1 - j) * columns + i];
      const share = Math.sqrt(Math.max(0, Math.min(1, (z - low_m) / Math.max(surface_m - low_m, 0.1))));
      const colour = z > surface_m ? land : deep.map((value, k) => value + (shoal[k] - value) * share);
      image.data.set([...colour, Number.isFinite(z) ? 255 : 0], 4 * (j * columns + i));
    }
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

const numbers = (colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
const lowest = (heights) => heights.reduce((least, value) => (value < least ? value : least), Infinity);

/** Contours of depth below the surface, by marching squares: depths in the pilot's unit, segments in metres.
 * @type {(heights: ArrayLike<number> & { reduce: any }, grid: Grid, surface_m: number) => Contour[]}
 */
export function contours(heights, { rows, columns, west_m, south_m, spacing_m: [dx, dy] }, surface_m) {
  const most = inUnit(surface_m - lowest(heights));
  if (!(most > 0 && Number.isFinite(most))) return [];
  const step = STEPS.find((each) => most / each <= CONTOURS) ?? 1000;
  const every = Math.max(1, Math.ceil(Math.max(rows, columns) / CELLS_MAX));
  /** @type {Contour[]} */
  const found = Array.from({ length: Math.floor(most / step) }, (_, k) => ({ depth: (k + 1) * step, segments: [] }));
  for (let j = 0; j + every < rows; j += every)
    for (let i = 0; i + every < columns; i += every) {
      const corners = /** @type {[number, number][]} */ ([
        [i, j],
        [i + every, j],
        [i + every, j + every],
        [i, j + every],
      ]);
      const deep = corners.map(([a, b]) => inUnit(surface_m - heights[b * columns + a]));
      const [least, greatest] = [Math.min(...deep), Math.max(...deep)];
      for (let k = Math.max(Math.ceil(least / step) - 1, 0); k < found.length && found[k].depth <= greatest; k += 1)
        found[k].segments.push(
          ...crossings(corners, deep, found[k].depth).map(
            ([x0, y0, x1, y1]) =>
              /** @type {Segment} */ ([west_m + x0 * dx, south_m + y0 * dy, west_m + x1 * dx, south_m + y1 * dy]),
          ),
        );
    }
  return found;
}

// Where a level crosses the edges of a cell, joined in pairs.
function crossings(corners, values, level) {
  const points = [];
  for (let k = 0; k < 4; k += 1) {
    const [a, b] = [values[k], values[(k + 1) % 4]];
    if (a < level === b < level || Number.isNaN(a + b)) continue;
    const [[x0, y0], [x1, y1]] = [corners[k], corners[(k + 1) % 4]];
    const share = (level - a) / (b - a);
    points.push([x0 + share * (x1 - x0), y0 + share * (y1 - y0)]);
  }
  return points.length === 4
    ? [points.slice(0, 2).flat(), points.slice(2).flat()]
    : points.length === 2
      ? [points.flat()]
      : [];
}
