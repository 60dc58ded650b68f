// The editor's chart: a scenario's bed and parts, which are dragged to move and turned by the wheel.
import { el, pen } from '../dom.js';
import { ChartFrame } from '../views/chart_frame.js';
import { ChartGround } from '../views/chart_ground.js';
import { drawScale, drawVessel, label } from '../views/chart_marks.js';
import { STARTS, contains, cornersOf, edgeDistance, isWithin, moved, placeOf, yawOf } from './geometry.js';

const NEAR_PX = 10;
const CLICK_PX = 4;
const PARTS_PX_M = 15; // the scale from which parts aboard are shown
const LABEL_PX = 16; // above a part
const EDGED = new Set(['survey', 'goals', 'limits']); // sections of which the edge alone is met by the pointer
const VESSEL = '#ffd166';
/** @type {Record<string, (colours: Record<string, string>) => string>} */
const OWN_COLOUR = { survey: ({ ink }) => ink, goals: ({ planned }) => planned, limits: ({ ink }) => ink };

export class EditorChart {
  frame = new ChartFrame();
  #ground = new ChartGround(null, null, 0, []);
  /** @type {{ from: number[], corner: number, isPart: boolean, moved: number, start: Record<string, any> } | null} */
  #drag = null;
  #fitted = ''; // the frame as it was fitted, '' for a new bed
  /** @type {[number, number, number][]} */
  #labels = []; // places and half widths of the names

  /** @param {import('./parts.js').EditedParts} parts
   * @param {import('./brush.js').Brush} brush
   */
  constructor(parts, brush) {
    this.parts = parts;
    this.brush = brush;
    parts.addEventListener('change', () => this.draw());
    this.canvas = el('canvas', {
      className: 'editor-canvas',
      tabIndex: 0,
      role: 'application',
      'aria-label': 'Chart of the scenario: drag a part to move it, turn the wheel on it to turn it',
    });
    this.#listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    addEventListener('theme', () => {
      this.#ground.recolour();
      this.draw();
    });
  }

  // isOther: another grid than before, not just other heights: it is shown whole.
  showBed(heights, grid, isOther) {
    this.#ground = new ChartGround(heights, grid, 0, []);
    if (isOther) this.#fitted = '';
    this.draw();
  }

  // The place at which a part is added, if none is marked in sight.
  get middle() {
    return this.frame.middle;
  }

  sees(place) {
    return isWithin(this.frame.at(place), this.frame.size);
  }

  fit() {
    const { grid } = this.#ground;
    if (!grid) return;
    const { rows, columns, west_m, south_m, spacing_m } = grid;
    this.frame.fit([west_m, south_m, west_m + (columns - 1) * spacing_m[0], south_m + (rows - 1) * spacing_m[1]]);
    this.#fitted = this.#shown;
    this.draw();
  }

  get #shown() {
    return JSON.stringify([this.frame.scale, this.frame.middle]);
  }

  zoom(factor) {
    const [width, height] = this.frame.size;
    this.frame.zoom(factor, [width / 2, height / 2]);
    this.draw();
  }

  // Bring the selected part into view; one aboard, at a scale at which it can be seen.
  reveal() {
    const part = this.parts.list[this.parts.selected];
    const place = part && placeOf(part, this.parts.fieldsOf(part));
    if (!place) return;
    const [x, y] = this.frame.at(place);
    const [width, height] = this.frame.size;
    const isAboard = part.vehicle !== null && part.section !== 'starts';
    if (isAboard && this.frame.scale < 4 * PARTS_PX_M) this.frame.scale = 8 * PARTS_PX_M;
    else if (x > 20 && y > 20 && x < width - 20 && y < height - 20) return;
    this.frame.middle = place;
    this.draw();
  }

  #listen() {
    const { canvas } = this;
    canvas.addEventListener('pointerdown', (event) => {
      const at = [event.offsetX, event.offsetY];
      canvas.setPointerCapture(event.pointerId);
      if (this.brush.isOn) {
        this.#paint(at);
        return;
      }
      const corner = this.#cornerAt(at);
      const hit = corner >= 0 ? this.parts.selected : this.#partAt(at);
      this.parts.pick(hit);
      this.#drag = { from: at, corner, isPart: hit >= 0, moved: 0, start: this.parts.at(hit) };
    });
    canvas.addEventListener('pointermove', (event) => {
      const at = [event.offsetX, event.offsetY];
      if (this.brush.line.length) this.#paint(at);
      else if (this.#drag) this.#move(at);
    });
    canvas.addEventListener('pointerup', () => {
      const line = this.brush.end();
      if (line.length) this.parts.painted(line);
      const drag = this.#drag;
      this.#drag = null;
      const isMoved = drag && drag.moved > CLICK_PX;
      if (drag?.isPart && isMoved) this.parts.done();
      else if (drag && !isMoved) this.parts.markAt(drag.isPart ? null : this.frame.place(drag.from));
    });
    canvas.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
  }

  #paint(at) {
    this.brush.to(this.frame.place(at));
    this.draw();
  }

  #move(at) {
    const drag = /** @type {any} */ (this.#drag);
    const [dx, dy] = [at[0] - drag.from[0], at[1] - drag.from[1]];
    drag.moved = Math.max(drag.moved, Math.hypot(dx, dy));
    if (!drag.isPart) {
      this.frame.pan(dx, dy);
      drag.from = at;
    } else if (drag.moved > CLICK_PX) {
      const by = /** @type {[number, number]} */ ([dx / this.frame.scale, -dy / this.frame.scale]);
      const part = /** @type {any} */ (drag.start);
      this.parts.change(moved(part, this.parts.fieldsOf(part), by, drag.corner));
    }
    this.draw();
  }

  #wheel(event) {
    event.preventDefault();
    const at = [event.offsetX, event.offsetY];
    const { parts } = this;
    if (parts.selected >= 0 && this.#partAt(at) === parts.selected) parts.turn(event);
    else this.frame.zoom(event.deltaY < 0 || event.deltaX < 0 ? 1.2 : 1 / 1.2, at);
    this.draw();
  }

  #isShown(index) {
    const { section } = this.parts.list[index];
    if (section === 'strokes') return index === this.parts.selected; // the bed shows what they have made of it
    const isAboard = this.parts.list[index].vehicle !== null && section !== 'starts';
    return !isAboard || index === this.parts.selected || this.frame.scale >= PARTS_PX_M;
  }

  #cornerAt(at) {
    if (this.parts.selected < 0) return -1;
    const part = this.parts.at(this.parts.selected);
    const near = (corner) => {
      const [x, y] = this.frame.at(corner);
      return Math.hypot(x - at[0], y - at[1]) < NEAR_PX;
    };
    return cornersOf(part, this.parts.fieldsOf(part)).findIndex(near);
  }

  // The part at a pixel: first the selected one, then the one whose position is nearest, then one that contains it; of
  // the survey's area the edge alone, since what lies in it is marked, added and moved there.
  #partAt(at) {
    const point = this.frame.place(at);
    const shown = this.parts.list.map((_, k) => k).filter((k) => this.#isShown(k));
    const away = (k) => {
      const part = this.parts.at(k);
      const place = placeOf(part, this.parts.fieldsOf(part));
      if (!place) return Infinity;
      const [x, y] = this.frame.at(place);
      return Math.hypot(x - at[0], y - at[1]);
    };
    const inside = (k) =>
      EDGED.has(this.parts.list[k].section)
        ? edgeDistance(this.#outline(k), point) * this.frame.scale < NEAR_PX
        : contains(this.#outline(k), point);
    if (this.parts.selected >= 0 && (away(this.parts.selected) < NEAR_PX || inside(this.parts.selected)))
      return this.parts.selected;
    const near = shown.filter((k) => away(k) < NEAR_PX).toSorted((a, b) => away(a) - away(b));
    return (
      near[0] ?? shown.find((k) => this.parts.list[k].section === 'obstacles' && inside(k)) ?? shown.find(inside) ?? -1
    );
  }

  // An obstacle's outline, moved and turned with changes that are not yet sent; of another part, its corners.
  #outline(index) {
    const [old, part] = [this.parts.list[index], this.parts.at(index)];
    const fields = this.parts.fieldsOf(part);
    if (!old.outline_m.length) return cornersOf(part, fields);
    if (cornersOf(part, fields).length)
      return index === this.parts.selected && Object.keys(this.parts.changes).length ? [] : old.outline_m;
    const [from, to] = [placeOf(old, fields), placeOf(part, fields)];
    if (!from || !to) return old.outline_m;
    const turn = (((yawOf(part, fields) ?? 0) - (yawOf(old, fields) ?? 0)) * Math.PI) / 180;
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    return old.outline_m.map(([x, y]) => {
      const [dx, dy] = [x - from[0], y - from[1]];
      return [to[0] + c * dx - s * dy, to[1] + s * dx + c * dy];
    });
  }

  draw() {
    const { canvas, frame } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    let isDue = this.#fitted === '';
    if (frame.size[0] !== width || frame.size[1] !== height) {
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
      frame.size = [width, height];
      isDue ||= this.#fitted === this.#shown; // a person's own view stays, for example when a message takes another line
    }
    if (this.#ground.grid && isDue) {
      this.fit();
      return;
    }
    const c = pen(canvas);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.#ground.draw(c, frame, ratio, true);
    c.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    this.#labels = [];
    if (this.parts.list[this.parts.selected]) this.#drawPart(c, this.parts.selected); // its name comes first ...
    this.parts.list.forEach((_, k) => k !== this.parts.selected && this.#isShown(k) && this.#drawPart(c, k));
    if (this.parts.list[this.parts.selected]) this.#drawPart(c, this.parts.selected); // ... and it lies on top
    if (this.brush.line.length) this.#drawStroke(c, this.brush.line, this.brush.width_m);
    if (this.parts.mark) this.#drawMark(c, frame.at(this.parts.mark));
    drawScale(c, frame, this.#ground.colours, 'N');
  }

  #drawPart(c, index) {
    const part = this.parts.at(index);
    const fields = this.parts.fieldsOf(part);
    const { colours } = this.#ground;
    const isSelected = index === this.parts.selected;
    const colour = isSelected ? colours.flown : (OWN_COLOUR[part.section]?.(colours) ?? colours.obstacle);
    const outline = part.section === 'strokes' ? [] : this.#outline(index);
    c.strokeStyle = c.fillStyle = colour;
    c.lineWidth = isSelected ? 2.5 : 1.4;
    if (outline.length > 1) {
      c.beginPath();
      for (const point of outline) c.lineTo(...this.frame.at(point));
      if (part.kind !== 'follow') c.closePath();
      c.globalAlpha = part.section === 'survey' ? 0.06 : 0.3;
      if (part.outline_m.length || part.section === 'survey') c.fill();
      c.globalAlpha = 1;
      c.stroke();
    }
    const corners = cornersOf(part, fields);
    if (part.section === 'strokes') this.#drawStroke(c, corners, part.values.width_m);
    if (isSelected && corners.length) this.#drawCorners(c, corners, part.section !== 'survey');
    const place = placeOf(part, fields);
    if (!place) return;
    const at = this.frame.at(place);
    const yaw = yawOf(part, fields);
    if (part.section === 'goals') this.#drawReach(c, at, part, fields);
    if (STARTS.has(part.section)) drawVessel(c, at, 90 - (yaw ?? 0), VESSEL);
    else if (isSelected || !outline.length) this.#drawMount(c, at, corners.length ? null : yaw, colours);
    if (isSelected || part.section !== 'survey') this.#label(c, part.name, at);
  }

  // The ground under the brush along a line.
  #drawStroke(c, line, width_m) {
    c.save();
    c.globalAlpha = 0.3;
    c.strokeStyle = this.#ground.colours.flown;
    c.lineCap = c.lineJoin = 'round';
    c.lineWidth = width_m * this.frame.scale;
    c.beginPath();
    for (const point of [line[0], ...line]) c.lineTo(...this.frame.at(point));
    c.stroke();
    c.restore();
  }

  // How near to a goal the vehicle has to come.
  #drawReach(c, at, { values }, fields) {
    const within_m = values.within_m ?? fields.find(({ name }) => name === 'within_m')?.by_default;
    if (!within_m || !values.position_m) return;
    c.beginPath();
    c.arc(...at, within_m * this.frame.scale, 0, 2 * Math.PI);
    c.stroke();
  }

  // Write a name where no other is in its way.
  #label(c, name, [x, y]) {
    const text = name.replaceAll('_', ' ');
    const half = c.measureText(text).width / 2;
    if (this.#labels.some(([a, b, other]) => Math.abs(a - x) < half + other && Math.abs(b - y) < LABEL_PX)) return;
    this.#labels.push([x, y, half]);
    label(c, text, x, y - LABEL_PX, this.#ground.colours);
  }

  // Corners, and for a line, such as a pipeline's, the line between them.
  #drawCorners(c, corners, isLine) {
    if (isLine) {
      c.beginPath();
      for (const corner of corners) c.lineTo(...this.frame.at(corner));
      c.stroke();
    }
    for (const corner of corners) {
      const [x, y] = this.frame.at(corner);
      c.fillRect(x - 5, y - 5, 10, 10);
    }
  }

  // Where a part is added.
  #drawMark(c, [x, y]) {
    c.strokeStyle = this.#ground.colours.ink;
    c.lineWidth = 2;
    c.beginPath();
    for (const [dx, dy] of [
      [9, 0],
      [0, 9],
    ]) {
      c.moveTo(x - dx, y - dy);
      c.lineTo(x + dx, y + dy);
    }
    c.stroke();
  }

  // A dot, and a line in the part's direction.
  #drawMount(c, [x, y], yaw, { halo }) {
    c.beginPath();
    c.arc(x, y, 4, 0, 2 * Math.PI);
    c.fill();
    c.strokeStyle = halo;
    c.lineWidth = 1;
    c.stroke();
    if (yaw === null) return;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x + 22 * Math.cos((yaw * Math.PI) / 180), y - 22 * Math.sin((yaw * Math.PI) / 180));
    c.strokeStyle = c.fillStyle;
    c.lineWidth = 2;
    c.stroke();
  }
}
