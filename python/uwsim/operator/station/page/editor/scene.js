// The editor's 3D view: the same parts as on the chart, moved, raised and turned by the mouse.
import { GLTFLoader, Vector3 } from '../vendor/three.js';
import { fixed } from '../dom.js';
import { firstShare } from '../map3d/sight.js';
import { Stage } from '../map3d/stage.js';
import { makeSurface, makeTerrain } from '../map3d/terrain.js';
import { isWithin, moved, raised } from './geometry.js';
import { PartSolids } from './solids.js';

const NEAR_PX = 12;
const CLICK_PX = 4;
const FAR_M = 3000; // of what can be pointed at
const REVEAL_M = 25; // from the camera to a part that is shown
const NEAR_M = { props: 8, aboard: 4 }; // the same for a prop and a part aboard
const BRIGHT = 2; // the bed, which lies behind a growing map in flight, is the ground here
const VIEW = [-0.5, -0.8, 0.7]; // from where the whole bed is seen

export class EditorScene extends Stage {
  #parts;
  #load;
  /** @type {import('./solids.js').PartSolids} */
  #solids;
  /** @type {any[]} */
  #ground = [];
  /** @type {import('../wire/messages.js').BedGrid | null} */
  #grid = null;
  /** @type {{ from: number[], at: Vector3 | null, corner: number, index: number, moved: number, start: any } | null} */
  #drag = null;

  /** load(path): fetches from the server.
   * @param {import('./parts.js').EditedParts} parts
   */
  constructor(parts, load) {
    super(
      'The scenario in 3D: drag a part to move it, with Shift to raise it, turn the wheel on it to turn it, click the bed to choose where to add',
    );
    [this.#parts, this.#load] = [parts, load];
    this.canvas.className = 'editor-scene';
    this.canvas.setAttribute('role', 'application');
    this.element = [this.canvas, this.note];
    if (!this.scene) return;
    this.controls.stopListenToKeyEvents?.(); // the arrow keys move parts
    this.#solids = new PartSolids(parts, () => this.redraw());
    this.show(this.#solids.group);
    parts.addEventListener('change', () => this.#solids.show());
    this.#listen();
    this.setLarge(true);
  }

  // True if every part can be pointed at: none is still under way from the server.
  get isWhole() {
    return Boolean(this.#solids?.isWhole);
  }

  // The place at which a part is added, if none is marked in sight: on the bed, in the middle of the picture.
  get middle() {
    if (!this.controls) return [0, 0];
    const [from, to] = this.#ray([this.canvas.clientWidth / 2, this.canvas.clientHeight / 2]);
    const share = this.#ground[0] ? shareOf(this.#ground[0], from, to) : Infinity;
    const { x, y } = Number.isFinite(share) ? from.lerp(to, share) : this.controls.target;
    return [x, y];
  }

  sees(place) {
    if (!this.controls) return false;
    const pixel = this.#pixelOf(new Vector3(place[0], place[1], this.#solids.bedAt(place)));
    return isWithin(pixel, [this.canvas.clientWidth, this.canvas.clientHeight]);
  }

  // isOther: as in EditorChart.
  showBed(heights, grid, isOther) {
    if (!this.scene) return;
    this.hide(...this.#ground);
    const { mesh, high_m } = makeTerrain(heights, grid, 0);
    mesh.material.color.setScalar(BRIGHT);
    this.#ground = [mesh, makeSurface(grid, Math.max(high_m, 0))];
    this.show(...this.#ground);
    this.#grid = grid;
    this.#solids.ground(mesh.geometry);
    if (isOther) this.fit();
  }

  // Show the solids of a state's obstacles and props.
  showSolids(state) {
    const loader = new GLTFLoader();
    this.#solids?.load(state, async (path) => {
      const { scene } = await loader.parseAsync(await (await this.#load(path)).arrayBuffer(), '');
      return scene;
    });
  }

  fit() {
    if (!this.#grid || !this.controls) return;
    const { rows, columns, west_m, south_m, spacing_m } = this.#grid;
    const size = [(columns - 1) * spacing_m[0], (rows - 1) * spacing_m[1]];
    const middle = [west_m + size[0] / 2, south_m + size[1] / 2];
    const target = new Vector3(middle[0], middle[1], this.#solids.bedAt(middle));
    this.aim(target.clone().add(new Vector3(...VIEW).multiplyScalar(0.75 * Math.max(...size))), target);
  }

  zoom(factor) {
    if (!this.controls) return;
    const { target } = this.controls;
    this.aim(this.camera.position.clone().sub(target).divideScalar(factor).add(target), target.clone());
  }

  // Bring the chosen part into view.
  reveal() {
    const { list, selected } = this.#parts;
    const part = list[selected];
    const place = part && this.#solids?.placeOf(selected);
    if (!place) return;
    const isAboard = part.vehicle !== null && part.section !== 'starts';
    const reach = NEAR_M[isAboard ? 'aboard' : part.section] ?? REVEAL_M;
    const away = this.camera.position.clone().sub(this.controls.target);
    if (away.length() > reach) away.setLength(reach);
    this.aim(place.clone().add(away), place);
  }

  draw() {
    this.redraw();
  }

  beforeDraw() {
    const away = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.min(0.5, 0.05 * away);
    this.camera.updateProjectionMatrix();
    this.#solids.scale(this.camera, this.canvas.clientHeight);
    this.canvas.ariaBusy = `${!this.isWhole}`;
  }

  noted() {
    const { mark } = this.#parts;
    return mark
      ? `Add puts it here: ${fixed(mark[0], 1)}, ${fixed(mark[1], 1)}`
      : 'Drag a part (Shift: up and down), turn the wheel on it; click the bed to choose where to add';
  }

  #listen() {
    const { canvas } = this;
    // Before the camera's controls, which come next for what is not a part.
    canvas.addEventListener('pointerdown', (event) => this.#press(event), { capture: true });
    canvas.addEventListener('pointermove', (event) => {
      if (this.#drag) this.#move(event);
    });
    canvas.addEventListener('pointerup', (event) => this.#release(event));
    canvas.addEventListener('pointercancel', () => this.#release(null));
    canvas.addEventListener('wheel', (event) => this.#wheel(event), { capture: true, passive: false });
  }

  #press(event) {
    if (event.button !== 0) return;
    this.canvas.focus({ preventScroll: true });
    const pixel = [event.offsetX, event.offsetY];
    const hit = this.#hit(pixel);
    if (hit.index >= 0) {
      this.#parts.pick(hit.index);
      this.controls.enabled = false;
      this.canvas.setPointerCapture(event.pointerId);
    }
    this.#drag = { from: pixel, ...hit, moved: 0, start: this.#parts.at(hit.index) };
  }

  #move({ offsetX, offsetY, shiftKey }) {
    const drag = /** @type {any} */ (this.#drag);
    const [dx, dy] = [offsetX - drag.from[0], offsetY - drag.from[1]];
    drag.moved = Math.max(drag.moved, Math.hypot(dx, dy));
    if (drag.index < 0 || drag.moved <= CLICK_PX) return;
    const fields = this.#parts.fieldsOf(drag.start);
    if (shiftKey) {
      this.#parts.change(raised(drag.start, fields, -dy * this.#metresPerPixel(drag.at)));
      return;
    }
    const to = this.#onLevel([offsetX, offsetY], drag.at.z);
    if (to) this.#parts.change(moved(drag.start, fields, [to.x - drag.at.x, to.y - drag.at.y], drag.corner));
  }

  #release(event) {
    const drag = this.#drag;
    this.#drag = null;
    this.controls.enabled = true;
    if (!drag) return;
    if (drag.index >= 0 && drag.moved > CLICK_PX) this.#parts.done();
    else if (!event || Math.hypot(event.offsetX - drag.from[0], event.offsetY - drag.from[1]) > CLICK_PX) return;
    else if (drag.index >= 0) this.#parts.markAt(null);
    else {
      this.#parts.pick(-1);
      this.#parts.markAt(drag.at ? [drag.at.x, drag.at.y] : null);
    }
  }

  #wheel(event) {
    const { selected } = this.#parts;
    if (selected < 0 || this.#hit([event.offsetX, event.offsetY]).index !== selected) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.#parts.turn(event);
  }

  // What lies under a pixel: the index of a part (or -1), the number of its corner (or -1), and the point that is met.
  #hit(pixel) {
    const { list, selected } = this.#parts;
    const near = (place) => {
      const at = this.#pixelOf(place);
      return at ? Math.hypot(at[0] - pixel[0], at[1] - pixel[1]) : Infinity;
    };
    const handles = this.#solids.cornersOf(selected);
    const corner = handles.findIndex((place) => near(place) < NEAR_PX);
    if (corner >= 0) return { index: selected, corner, at: handles[corner] };
    const marks = list
      .map((_, index) => ({ index, at: this.#solids.markOf(index) }))
      .filter(({ at }) => at && near(at) < NEAR_PX)
      .toSorted((a, b) => near(a.at) - near(b.at));
    if (marks[0]) return { ...marks[0], corner: -1 };
    const [from, to] = this.#ray(pixel);
    const bed = this.#ground[0] ? shareOf(this.#ground[0], from, to) : Infinity;
    let found = { index: -1, share: bed };
    for (const [index, node] of this.#solids.nodes()) {
      const share = shareOf(node, from, to);
      if (share < found.share) found = { index, share };
    }
    const at = Number.isFinite(found.share) ? from.clone().lerp(to, found.share) : null;
    return { index: found.index, corner: -1, at };
  }

  // The pixel of a place, null behind the camera.
  #pixelOf(place) {
    this.camera.updateMatrixWorld();
    const { x, y, z } = place.clone().project(this.camera);
    if (z > 1) return null;
    return [((x + 1) / 2) * this.canvas.clientWidth, ((1 - y) / 2) * this.canvas.clientHeight];
  }

  #ray([px, py]) {
    const { clientWidth, clientHeight } = this.canvas;
    this.camera.updateMatrixWorld(); // also before the next picture is drawn
    const from = this.camera.position.clone();
    const way = new Vector3((2 * px) / clientWidth - 1, 1 - (2 * py) / clientHeight, 0.5).unproject(this.camera);
    return [from, way.sub(from).setLength(FAR_M).add(from)];
  }

  // The point at a height under a pixel; null if it is too far away.
  #onLevel(pixel, height) {
    const [from, to] = this.#ray(pixel);
    const share = (height - from.z) / (to.z - from.z);
    return share > 0 && share < 1 ? from.lerp(to, share) : null;
  }

  #metresPerPixel(at) {
    const tall = 2 * Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.position.distanceTo(at);
    return tall / this.canvas.clientHeight;
  }
}

// The share of the way between two points at which it first meets a node's meshes.
function shareOf(node, from, to) {
  let found = Infinity;
  node.updateWorldMatrix(true, true);
  node.traverse((part) => {
    if (!part.isMesh || !part.visible) return;
    const ends = [from, to].map((end) => part.worldToLocal(end.clone()).toArray());
    const { position } = part.geometry.attributes;
    found = Math.min(found, firstShare(position.array, part.geometry.index?.array ?? null, ends[0], ends[1]));
  });
  return found;
}
