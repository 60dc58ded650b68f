// The 3D view of one map, without a lake or a vehicle: from above and from four sides.
import { Vector3 } from '../vendor/three.js';
import { capital, el, fixed, pen } from '../dom.js';
import { Stage } from './stage.js';
import { RAMP } from './voxel_points.js';

const SIDES = { above: [0, -0.001, 1], south: [0, -1, 0.6], east: [1, 0, 0.6], north: [0, 1, 0.6], west: [-1, 0, 0.6] };
const MARGIN = 1.05;

export class MapView extends Stage {
  #centre = new Vector3();
  /** @type {Vector3[]} */
  #corners = []; // of the map's box, from its centre
  #reach_m = 1;
  #edge_m = 1;

  // about: the server's map.json.
  constructor({ low_m, high_m, cube_m, coloured_m: [low, high] }) {
    super("3D view of the map's occupied voxels");
    const buttons = Object.keys(SIDES).map((side) =>
      el('button', { type: 'button', onclick: () => this.look(side) }, capital(side)),
    );
    const tools = el('div', { className: 'scene-tools', role: 'group', 'aria-label': 'View from' }, ...buttons);
    this.element = [this.canvas, tools, heights(low, high), this.note];
    if (!this.scene) return;
    this.voxels.setRange(low, high);
    this.#edge_m = cube_m;
    this.#centre.fromArray(low_m.map((value, k) => (value + high_m[k]) / 2));
    const half = new Vector3().fromArray(high_m).sub(this.#centre);
    for (let k = 0; k < 8; k += 1)
      this.#corners.push(new Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).multiply(half));
    this.#reach_m = half.length();
    this.controls.minDistance = 4 * cube_m;
    this.controls.maxDistance = 6 * this.#reach_m;
    this.setLarge(true);
  }

  // Look at the whole map from a side, from where its box fills the picture.
  look(side) {
    const back = new Vector3(...SIDES[side]).normalize();
    const right = new Vector3(0, 0, 1).cross(back).normalize();
    const up = back.clone().cross(right);
    const high = Math.tan((this.camera.fov * Math.PI) / 360);
    const wide = (high * this.canvas.clientWidth) / (this.canvas.clientHeight || 1);
    const away = this.#corners.map(
      (corner) =>
        corner.dot(back) + MARGIN * Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high),
    );
    this.aim(this.#centre.clone().addScaledVector(back, Math.max(...away)), this.#centre);
  }

  beforeDraw() {
    const distance = this.camera.position.distanceTo(this.#centre);
    this.camera.near = Math.max(this.#edge_m, (distance - 1.1 * this.#reach_m) / 2);
    this.camera.far = distance + 1.1 * this.#reach_m + this.#edge_m;
    this.camera.updateProjectionMatrix();
  }
}

// The colours' key: from the lowest to the highest height.
function heights(low, high) {
  const bar = el('canvas', { width: 120, height: 10, 'aria-hidden': 'true' });
  const brush = pen(bar);
  const shades = brush.createLinearGradient(0, 0, bar.width, 0);
  RAMP.forEach((colour, k) => shades.addColorStop(k / (RAMP.length - 1), colour));
  brush.fillStyle = shades;
  brush.fillRect(0, 0, bar.width, bar.height);
  return el('p', { className: 'map-heights' }, `z ${fixed(low, 1)}`, bar, `${fixed(high, 1)} m`);
}
