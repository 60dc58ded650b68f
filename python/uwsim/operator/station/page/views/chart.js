// The chart: bed colours by depth, obstacles by name, tracks, measuring, and waypoints that the server saves and flies.
import { all, attempt, el, fixed, pen, toast, write } from '../dom.js';
import { STRINGS } from '../strings.js';
import { inUnit, unitName } from '../units.js';
import { PLAN_SPEEDS_M_S, plan as request } from '../wire/messages.js';
import { attitude } from '../attitude.js';
import { ChartFrame, heightAt, measured, pathLength } from './chart_frame.js';

const WORDS = STRINGS.chart;
const DEEP = [84, 134, 180];
const SHOAL = [222, 240, 244];
const LAND = [196, 178, 128];
const TRACK_MAX = 5000;
const TRACK_M = 0.1; // between points of a track
const REPORT_MS = 500;
const CLICK_PX = 5; // a press that moves less is a click
const INK = '#06121c';
const FLOWN = '#c2410c';
const PLANNED = '#6b1580';
const NOTED = '#e8c22e';
const NOTED_WRONG = '#ff7a66';
const SHORT = 24; // letters of a note on the chart

const button = (text, act) => el('button', { type: 'button', onclick: act }, text);
const number = (title, value, min, max, step) =>
  el('input', { type: 'number', 'aria-label': title, title, value, min, max, step });

export class ChartView {
  name = 'chart';
  kind = 'chart';
  title = WORDS.title;
  frame = new ChartFrame();
  vehicle = '';
  points = []; // waypoints [x, y, z], in odom
  flown = []; // [x, y]
  layers = []; // additional drawing functions (context, frame)
  #notes = []; // with position_m
  #isLarge = false;
  /** @type {[number, number] | null} */
  #place = null; // of the pointer
  /** @type {{ canvas: OffscreenCanvas, heights: Float32Array, grid: any, surface_m: number } | null} */
  #bed = null; // { canvas, heights, grid, surface_m }
  #meshes = [];
  #ruler = [];
  #tool = '';
  /** @type {{ from: number[], moved: number } | null} */
  #drag = null;
  /** @type {import('../wire/messages.js').Telemetry | null} */
  #message = null;
  #timer = 0;
  #isFitted = false;

  constructor(station) {
    this.station = station;
    this.canvas = el('canvas', { role: 'img', 'aria-label': WORDS.picture });
    this.note = el('p', { className: 'scene-note', role: 'status' }, WORDS.noPlan);
    const tool = (name, text) =>
      el(
        'button',
        { type: 'button', 'aria-pressed': 'false', 'data-tool': name, onclick: () => this.#choose(name) },
        text,
      );
    this.depth = number(WORDS.depth, 2, 0, 1000, 0.5);
    this.speed = number(WORDS.speed, 0.5, ...PLAN_SPEEDS_M_S, 0.05);
    this.planName = el('input', { type: 'text', 'aria-label': WORDS.name, title: WORDS.name, value: 'plan' });
    this.fly = button(WORDS.fly, () => this.#ask('fly'));
    this.stop = button(WORDS.stop, () => this.#ask('stop'));
    this.tools = el(
      'div',
      { className: 'scene-tools chart-tools', role: 'group', 'aria-label': WORDS.tools },
      tool('add', WORDS.add),
      tool('measure', WORDS.measure),
      button(WORDS.undo, () => this.#change(() => this.points.pop())),
      button(WORDS.clear, () => this.#change(() => ([this.points, this.#ruler] = [[], []]))),
      button(WORDS.fit, () => this.#fit()),
      this.depth,
      this.speed,
      this.planName,
      button(WORDS.save, () => this.#ask('save')),
      this.fly,
      this.stop,
    );
    this.element = [this.canvas, this.tools, this.note];
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    this.draw();
  }

  // Show another simulator's bed. load(path): fetches from it; sceneUrl: its scene.json, '' if no server offers one.
  async begin(load, vehicle, sceneUrl) {
    [this.vehicle, this.flown, this.#meshes, this.#bed, this.#isFitted] = [vehicle, [], [], null, false];
    if (!sceneUrl) return;
    const found = await (await load(sceneUrl)).json();
    const heights = new Float32Array(await (await load(found.terrain.url)).arrayBuffer());
    this.#meshes = found.meshes.filter(({ outline_m }) => outline_m?.length > 1);
    this.#bed = coloured(heights, found.terrain, found.surface_m ?? 0);
    if (this.#place) this.#describe(this.#place); // the pointer already rests on the chart
    this.draw();
  }

  showNotes(notes) {
    this.#notes = notes;
    this.draw();
  }

  showTelemetry(message) {
    this.#message = message;
    const [x, y] = message.position;
    const last = this.flown.at(-1);
    if (Number.isFinite(x) && (!last || Math.hypot(x - last[0], y - last[1]) > TRACK_M)) {
      this.flown = [...this.flown.slice(-TRACK_MAX), [x, y]];
    }
    if (!document.hidden) this.draw();
  }

  #change(act) {
    act();
    this.draw();
    this.#describe();
  }

  #choose(name) {
    this.#tool = this.#tool === name ? '' : name;
    this.#ruler = [];
    for (const each of all(this.tools, '[data-tool]'))
      each.setAttribute('aria-pressed', String(each.dataset.tool === this.#tool));
    this.draw();
  }

  #listen() {
    const { canvas } = this;
    canvas.addEventListener('pointerdown', (event) => {
      this.#drag = { from: [event.offsetX, event.offsetY], moved: 0 };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', (event) => {
      const at = [event.offsetX, event.offsetY];
      if (this.#drag) {
        const [dx, dy] = [at[0] - this.#drag.from[0], at[1] - this.#drag.from[1]];
        this.#drag.moved += Math.hypot(dx, dy);
        if (this.#drag.moved > CLICK_PX) this.frame.pan(dx, dy);
        this.#drag.from = at;
      }
      this.draw();
      this.#describe(this.frame.place(at));
    });
    canvas.addEventListener('pointerup', (event) => {
      const isClick = this.#drag && this.#drag.moved <= CLICK_PX;
      this.#drag = null;
      if (isClick) this.#click(this.frame.place([event.offsetX, event.offsetY]));
    });
    canvas.addEventListener(
      'wheel',
      (event) => {
        event.preventDefault();
        this.frame.zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2, [event.offsetX, event.offsetY]);
        this.draw();
      },
      { passive: false },
    );
  }

  #click(place) {
    if (this.#tool === 'add') {
      const depth = Math.max(Number(this.depth.value) || 0, 0);
      this.#change(() => this.points.push([...place, (this.#bed?.surface_m ?? 0) - depth]));
    } else if (this.#tool === 'measure') {
      this.#ruler = this.#ruler.length === 1 ? [this.#ruler[0], place] : [place];
      this.draw();
      this.#describe();
    }
  }

  async #ask(action) {
    const { points, station } = this;
    const args = {
      action,
      vehicle: this.vehicle,
      points_m: points,
      speed_m_s: Number(this.speed.value),
      name: this.planName.value,
    };
    const answer = await attempt(request(station.bridge, action === 'stop' ? { action } : args));
    if (!answer) return;
    if (action === 'save') toast(answer.message || WORDS.saved);
    else this.#follow(answer);
  }

  // Report on a plan while it is flown.
  #follow(state) {
    clearTimeout(this.#timer);
    this.state = state;
    write(
      this.note,
      state.is_flying ? WORDS.flying(state.reached, this.points.length) : WORDS.ended(state.ended_because),
    );
    if (!state.is_flying) return;
    this.#timer = setTimeout(async () => {
      try {
        this.#follow(await request(this.station.bridge, { action: 'report' }));
      } catch {
        this.#follow(state);
      }
    }, REPORT_MS);
  }

  /** @param {[number, number] | null} place */
  #describe(place = null) {
    this.#place = place;
    if (this.state?.is_flying) return;
    if (this.#ruler.length === 2) {
      const { length_m, bearing_deg } = measured(this.#ruler[0], this.#ruler[1]);
      write(this.note, WORDS.measured(fixed(length_m, 1), fixed(bearing_deg, 0).padStart(3, '0')));
    } else if (place && this.#bed) {
      const deep_m = this.#bed.surface_m - heightAt(this.#bed.heights, this.#bed.grid, place);
      const depth = deep_m > 0 ? WORDS.deep(`${fixed(inUnit(deep_m), 1)} ${unitName()}`) : WORDS.land;
      write(this.note, WORDS.cursor(fixed(place[0], 1), fixed(place[1], 1), Number.isFinite(deep_m) ? depth : '–'));
    } else write(this.note, this.points.length > 1 ? WORDS.left(fixed(pathLength(this.points), 0)) : WORDS.noPlan);
  }

  #fit() {
    if (!this.#bed) return;
    const { rows, columns, west_m, south_m, spacing_m } = this.#bed.grid;
    this.frame.fit([west_m, south_m, west_m + (columns - 1) * spacing_m[0], south_m + (rows - 1) * spacing_m[1]]);
    this.draw();
  }

  draw() {
    const { canvas, frame } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const isNew = frame.size[0] !== width || frame.size[1] !== height;
    if (isNew) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
      frame.size = [width, height];
    }
    if (this.#bed && (isNew || !this.#isFitted)) {
      this.#isFitted = true;
      this.#fit();
      return;
    }
    const c = pen(canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = '#8fa3ad';
    c.fillRect(0, 0, width, height);
    c.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    if (this.#bed) this.#drawBed(c, this.#bed);
    for (const { name, outline_m } of this.#meshes) this.#drawObstacle(c, name, outline_m);
    this.#drawLine(c, this.flown, FLOWN, []);
    this.#drawPlan(c);
    for (const note of this.#notes) this.#drawNote(c, note);
    this.#drawRuler(c);
    for (const layer of this.layers) layer(c, frame);
    this.#drawVehicle(c);
    if (this.#isLarge) this.#drawScale(c);
  }

  #drawBed(c, { canvas, grid }) {
    const [x, y] = this.frame.at([
      grid.west_m - grid.spacing_m[0] / 2,
      grid.south_m + (grid.rows - 0.5) * grid.spacing_m[1],
    ]);
    const { scale } = this.frame;
    c.drawImage(canvas, x, y, grid.columns * grid.spacing_m[0] * scale, grid.rows * grid.spacing_m[1] * scale);
  }

  #drawObstacle(c, name, outline) {
    c.beginPath();
    outline.forEach((point, k) => (k ? c.lineTo(...this.frame.at(point)) : c.moveTo(...this.frame.at(point))));
    c.closePath();
    c.fillStyle = 'rgb(70 20 90 / .3)';
    c.strokeStyle = '#46145a';
    c.lineWidth = 1.2;
    c.fill();
    c.stroke();
    if (!this.#isLarge) return;
    const middle = [0, 1].map((axis) => outline.reduce((sum, point) => sum + point[axis], 0) / outline.length);
    label(c, name.replaceAll('_', ' '), ...this.frame.at(middle));
  }

  #drawLine(c, points, colour, dashes) {
    if (points.length < 2) return;
    c.beginPath();
    points.forEach((point, k) => (k ? c.lineTo(...this.frame.at(point)) : c.moveTo(...this.frame.at(point))));
    c.strokeStyle = colour;
    c.lineWidth = 2;
    c.setLineDash(dashes);
    c.stroke();
    c.setLineDash([]);
  }

  #drawPlan(c) {
    this.#drawLine(c, this.points, PLANNED, [7, 5]);
    this.points.forEach((point, k) => {
      const [x, y] = this.frame.at(point);
      c.beginPath();
      c.arc(x, y, 5, 0, 2 * Math.PI);
      c.fillStyle = k < (this.state?.reached ?? 0) ? FLOWN : '#fff';
      c.fill();
      c.strokeStyle = PLANNED;
      c.lineWidth = 2;
      c.stroke();
      if (this.#isLarge) label(c, String(k + 1), x + 12, y - 8);
    });
  }

  // A pin with its number, and with its text where there is room.
  #drawNote(c, { number: index, category, text, position_m }) {
    const [x, y] = this.frame.at(position_m);
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x - 7, y - 13);
    c.arc(x, y - 16, 8, Math.PI - 0.4, 0.4);
    c.closePath();
    c.fillStyle = category === 'defect' || category === 'leak' ? NOTED_WRONG : NOTED;
    c.fill();
    c.strokeStyle = INK;
    c.lineWidth = 1.2;
    c.stroke();
    label(c, String(index), x, y - 17);
    if (this.#isLarge && text) label(c, text.length > SHORT ? `${text.slice(0, SHORT)}…` : text, x, y - 33);
  }

  #drawRuler(c) {
    this.#drawLine(c, this.#ruler, INK, [3, 3]);
    for (const point of this.#ruler) {
      const [x, y] = this.frame.at(point);
      c.fillStyle = INK;
      c.fillRect(x - 3, y - 3, 6, 6);
    }
  }

  #drawVehicle(c) {
    if (!this.#message || !Number.isFinite(this.#message.position[0])) return;
    drawVessel(
      c,
      this.frame.at([...this.#message.position]),
      attitude(this.#message.orientation).heading_deg,
      '#ffd166',
    );
  }

  #drawScale(c) {
    const step = [1, 2, 5, 10, 20, 50, 100, 200, 500].find((metres) => metres * this.frame.scale > 70) ?? 1000;
    const [x, y] = [this.frame.size[0] / 2 - (step * this.frame.scale) / 2, this.frame.size[1] - 18];
    c.fillStyle = INK;
    c.fillRect(x, y, step * this.frame.scale, 3);
    label(c, `${step} m`, this.frame.size[0] / 2, y - 10);
  }
}

// An arrow at a vehicle's position, along its heading.
export function drawVessel(c, [x, y], heading_deg, colour) {
  c.save();
  c.translate(x, y);
  c.rotate((heading_deg * Math.PI) / 180);
  c.beginPath();
  c.moveTo(0, -11);
  c.lineTo(7, 8);
  c.lineTo(0, 4);
  c.lineTo(-7, 8);
  c.closePath();
  c.fillStyle = colour;
  c.fill();
  c.strokeStyle = INK;
  c.lineWidth = 1.5;
  c.stroke();
  c.restore();
}

// The bed as a picture with one pixel per grid point: darker where deeper, with depth contours.
function coloured(heights, grid, surface_m) {
  const { rows, columns } = grid;
  const canvas = new OffscreenCanvas(columns, rows);
  const context = pen(canvas);
  const image = context.createImageData(columns, rows);
  const known = heights.filter(Number.isFinite);
  const low_m = known.reduce((least, value) => Math.min(least, value), Infinity);
  for (let j = 0; j < rows; j += 1) {
    for (let i = 0; i < columns; i += 1) {
      const z = heights[(rows - 1 - j) * columns + i];
      const share = Math.sqrt(Math.max(0, Math.min(1, (z - low_m) / Math.max(surface_m - low_m, 0.1))));
      const colour = z > surface_m ? LAND : DEEP.map((value, c) => value + (SHOAL[c] - value) * share);
      image.data.set([...colour, Number.isFinite(z) ? 255 : 0], 4 * (j * columns + i));
    }
  }
  context.putImageData(image, 0, 0);
  return { canvas, heights, grid, surface_m };
}

function label(c, text, x, y) {
  c.save();
  c.textAlign = 'center';
  c.textBaseline = 'middle';
  c.strokeStyle = 'rgb(255 255 255 / .85)';
  c.lineWidth = 3;
  c.strokeText(text, x, y);
  c.fillStyle = INK;
  c.fillText(text, x, y);
  c.restore();
}
