// The chart: bed colours by depth, obstacles by name, tracks, measuring, and waypoints that the server saves and flies.
import { all, attempt, el, fixed, pen, toast, write } from '../dom.js';
import { isHandheld } from '../handheld.js';
import { inUnit, unitName } from '../units.js';
import { PLAN_SPEEDS_M_S, plan as request } from '../wire/messages.js';
import { attitude } from '../attitude.js';
import { ChartFrame, heightAt, measured, pathLength } from './chart_frame.js';
import { ChartGround } from './chart_ground.js';
import { ARROW_PX, drawNote, drawScale, drawVehicle, drawWaypoints } from './chart_marks.js';

const TRACK_MAX = 5000;
const TRACK_M = 0.1; // between points of a track
const REPORT_MS = 500;
const CLICK_PX = 5; // a press that moves less is a click
const FOOT_PX = 42; // of a hand-held screen, for the note at its lower edge
const VEHICLE = '#ffd166';

const button = (text, act) => el('button', { type: 'button', onclick: act }, text);
const number = (title, value, min, max, step) =>
  el('input', { type: 'number', 'aria-label': title, title, value, min, max, step });
const field = (name, input, unit) => el('label', {}, name, input, unit);

export class ChartView {
  name = 'chart';
  kind = 'chart';
  title = 'Chart';
  frame = new ChartFrame();
  vehicle = '';
  points = []; // waypoints [x, y, z], in odom
  flown = []; // [x, y]
  layers = []; // additional drawing functions (context, frame, isLarge, colours)
  #notes = []; // with position_m
  #isLarge = false;
  /** @type {[number, number] | null} */
  #place = null; // of the pointer
  #ground = new ChartGround(null, null, 0, []);
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
    this.canvas = el('canvas', { role: 'img', 'aria-label': 'Chart with tracks, waypoints and obstacles' });
    this.note = el('p', { className: 'scene-note', role: 'status' }, 'Choose Waypoint, then click on the chart');
    const tool = (name, text) => {
      const found = button(text, () => this.#choose(name));
      found.dataset.tool = name;
      found.setAttribute('aria-pressed', 'false');
      return found;
    };
    this.depth = number('Depth of waypoints [m]', 2, 0, 1000, 0.5);
    this.speed = number('Speed [m/s]', 0.5, ...PLAN_SPEEDS_M_S, 0.05);
    this.planName = el('input', {
      type: 'text',
      'aria-label': 'Name of the plan',
      title: 'Name of the plan',
      value: 'plan',
    });
    this.lanes = button('Survey lanes', () => this.layLanes());
    this.fly = button('Fly', () => this.#ask('fly'));
    this.stop = button('Stop', () => this.#ask('stop'));
    this.tools = el(
      'div',
      { className: 'scene-tools chart-tools', role: 'group', 'aria-label': 'Chart tools' },
      tool('add', 'Waypoint'),
      this.lanes,
      tool('measure', 'Measure'),
      button('Undo', () => this.#change(() => this.points.pop())),
      button('Clear', () => this.#change(() => ([this.points, this.#ruler] = [[], []]))),
      button('Fit', () => this.#fit()),
      field('Depth', this.depth, 'm'),
      field('Speed', this.speed, 'm/s'),
      field('Name', this.planName, null),
      button('Save', () => this.#ask('save')),
      this.fly,
      this.stop,
    );
    this.element = [this.canvas, this.tools, this.note];
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    addEventListener('theme', () => {
      this.#ground.recolour();
      this.draw();
    });
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    this.draw();
  }

  // Show another simulator's bed. load(path): fetches from it; sceneUrl: its scene.json, '' if no server offers one.
  async begin(load, vehicle, sceneUrl) {
    [this.vehicle, this.flown, this.#isFitted] = [vehicle, [], false];
    this.#ground = new ChartGround(null, null, 0, []);
    if (!sceneUrl) return;
    const found = await (await load(sceneUrl)).json();
    const grid = found.chart ?? found.terrain; // of a basin, such as a pool, or of the terrain
    const heights = new Float32Array(await (await load(grid.url)).arrayBuffer());
    const isGround = (name) => found.chart?.meshes.includes(name) ?? false;
    const meshes = found.meshes.filter(({ name, outline_m }) => outline_m?.length > 1 && !isGround(name));
    this.#ground = new ChartGround(heights, grid, found.surface_m ?? 0, meshes);
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
    [this.#tool, this.#ruler] = [this.#tool === name ? '' : name, []];
    for (const each of all(this.tools, '[data-tool]')) each.ariaPressed = String(each.dataset.tool === this.#tool);
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
      this.#change(() => this.points.push([...place, this.#ground.surface_m - depth]));
    } else if (this.#tool === 'measure') {
      this.#ruler = this.#ruler.length === 1 ? [this.#ruler[0], place] : [place];
      this.draw();
      this.#describe();
    }
  }

  // Plan the lanes of the scenario's survey.
  async layLanes() {
    const answer = await attempt(request(this.station.bridge, { action: 'lanes' }));
    if (!answer) return;
    this.speed.value = answer.speed_m_s;
    this.#change(() => (this.points = answer.points_m));
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
    if (action === 'save') toast(answer.message || 'Plan saved');
    else this.#follow(answer);
  }

  // Report on a plan while it is flown.
  #follow(state) {
    clearTimeout(this.#timer);
    this.state = state;
    write(
      this.note,
      state.is_flying
        ? `Flying the plan: ${state.reached} of ${this.points.length} waypoints`
        : `Plan ended: ${state.ended_because}`,
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
      write(this.note, `${fixed(length_m, 1)} m, ${fixed(bearing_deg, 0).padStart(3, '0')}°`);
    } else if (place && this.#ground.grid) {
      const deep_m = this.#ground.surface_m - heightAt(this.#ground.heights, this.#ground.grid, place);
      const depth = deep_m > 0 ? `${fixed(inUnit(deep_m), 1)} ${unitName()} deep` : 'land';
      write(
        this.note,
        `east ${fixed(place[0], 1)}, north ${fixed(place[1], 1)} m, ${Number.isFinite(deep_m) ? depth : '–'}`,
      );
    } else
      write(
        this.note,
        this.points.length > 1
          ? `${fixed(pathLength(this.points), 0)} m planned`
          : 'Choose Waypoint, then click on the chart',
      );
  }

  #fit() {
    if (!this.#ground.grid) return;
    const { rows, columns, west_m, south_m, spacing_m } = this.#ground.grid;
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
    if (this.#ground.grid && (isNew || !this.#isFitted)) {
      this.#isFitted = true;
      this.#fit();
      return;
    }
    const c = pen(canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    const { colours } = this.#ground;
    this.#ground.draw(c, frame, ratio, this.#isLarge);
    this.#drawLine(c, this.flown, colours.flown, []);
    this.#drawLine(c, this.points, colours.planned, [7, 5]);
    drawWaypoints(c, frame, this.points, this.state?.reached ?? 0, this.#isLarge, colours);
    for (const note of this.#notes) drawNote(c, frame, note, this.#isLarge, colours);
    this.#drawRuler(c, colours.ink);
    for (const layer of this.layers) layer(c, frame, this.#isLarge, colours);
    const { position = [NaN], orientation = [] } = this.#message ?? {};
    if (Number.isFinite(position[0]))
      drawVehicle(c, frame, [...position], attitude(orientation).heading_deg, VEHICLE, colours);
    if (this.#isLarge) drawScale(c, frame, colours, 'N', this.#margins());
  }

  // The edges that other things lie over. On a hand-held screen, the chart begins below its tools.
  #margins() {
    if (isHandheld()) return { foot_px: FOOT_PX };
    const { offsetLeft, offsetTop, offsetHeight } = this.tools;
    return { head_px: offsetLeft < 2 * ARROW_PX ? offsetTop + offsetHeight : 0 };
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

  #drawRuler(c, ink) {
    this.#drawLine(c, this.#ruler, ink, [3, 3]);
    for (const point of this.#ruler) {
      const [x, y] = this.frame.at(point);
      c.fillStyle = ink;
      c.fillRect(x - 3, y - 3, 6, 6);
    }
  }
}
