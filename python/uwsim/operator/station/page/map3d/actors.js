// The actors of the 3D view: the vehicle, its track, the fan of its sonar, marks.
import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Vector3,
} from '../vendor/three.js';
import { faceted } from './terrain.js';

const TRACK_MOST = 16384; // points; beyond it every second one is dropped
const TRACK_STEP_M = 0.3;
const FAN_RAYS = 64;

export class Track {
  #positions = new Float32Array(TRACK_MOST * 3);
  #count = 0;
  #step = TRACK_STEP_M;
  #last = new Vector3(NaN, 0, 0);

  constructor() {
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute('position', new BufferAttribute(this.#positions, 3));
    this.line = new Line(this.geometry, new LineBasicMaterial({ color: 0xffb347 }));
    this.line.frustumCulled = false;
    this.clear();
  }

  clear() {
    this.#count = 0;
    this.#step = TRACK_STEP_M;
    this.#last.x = NaN;
    this.geometry.setDrawRange(0, 0);
  }

  add(point) {
    if (point.distanceTo(this.#last) < this.#step) return; // the first distance is NaN
    if (this.#count === TRACK_MOST) this.#thin();
    this.#last.copy(point);
    this.#positions.set([point.x, point.y, point.z], 3 * this.#count);
    this.#count += 1;
    this.geometry.setDrawRange(0, this.#count);
    this.geometry.attributes.position.needsUpdate = true;
  }

  #thin() {
    for (let k = 0; k < TRACK_MOST / 2; k += 1) this.#positions.copyWithin(3 * k, 6 * k, 6 * k + 3);
    this.#count = TRACK_MOST / 2;
    this.#step *= 2;
  }
}

// Poles at the positions of notes.
export class Marks {
  group = new Group();
  count = 0;
  #material = new LineBasicMaterial({ color: 0xff6ad5 });
  #lines = [];

  add([x, y, z]) {
    const geometry = new BufferGeometry();
    const lines = [x, y, z - 4, x, y, z + 4, x - 1, y, z, x + 1, y, z, x, y - 1, z, x, y + 1, z];
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(lines), 3));
    this.#lines.push(new LineSegments(geometry, this.#material));
    this.group.add(this.#lines.at(-1));
    this.count += 1;
  }

  clear() {
    for (const line of this.#lines) line.geometry.dispose();
    this.#lines = [];
    this.group.clear();
    this.count = 0;
  }
}

export class Vessel {
  group = new Group(); // in the world, at the vehicle's pose
  track = new Track();
  #fan;
  #positions = new BufferAttribute(new Float32Array((FAN_RAYS + 1) * 3), 3); // of the fan

  constructor() {
    this.material = new MeshLambertMaterial({ color: 0xffc14d, emissive: 0x4a3200 });
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', this.#positions);
    geometry.setIndex(Array.from({ length: FAN_RAYS - 1 }, (_, k) => [0, k + 1, k + 2]).flat());
    this.#fan = new Mesh(
      geometry,
      new MeshBasicMaterial({ color: 0x49d6e6, transparent: true, opacity: 0.22, side: DoubleSide, depthWrite: false }),
    );
    this.#fan.frustumCulled = false;
    this.#fan.visible = false;
    this.group.add(this.#fan);
  }

  setHull(hull) {
    hull.traverse((node) => {
      if (!node.isMesh) return;
      faceted(node);
      node.material = this.material;
    });
    this.group.add(hull);
  }

  // Move the vehicle to its true pose, from which the sonar maps, or else to the estimated one.
  move({ position, true_position: truth, is_truth: isTruth, orientation }) {
    this.group.position.fromArray(isTruth ? truth : position);
    this.group.quaternion.fromArray(orientation);
    this.track.add(this.group.position);
  }

  // Draw the newest ping. tilt_rad: the head's tilt, positive up. Beams without an echo end at the maximum range.
  setFan({ angle_min, angle_increment, ranges, range_max }, tilt_rad) {
    const positions = this.#positions;
    positions.setXYZ(0, 0, 0, 0);
    const [cos, sin] = [Math.cos(tilt_rad), Math.sin(tilt_rad)];
    for (let k = 0; k < FAN_RAYS; k += 1) {
      const beam = Math.round((k * (ranges.length - 1)) / (FAN_RAYS - 1));
      const range = Number.isFinite(ranges[beam]) ? ranges[beam] : range_max;
      const angle = angle_min + beam * angle_increment;
      const ahead = range * Math.cos(angle);
      positions.setXYZ(k + 1, ahead * cos, range * Math.sin(angle), ahead * sin);
    }
    positions.needsUpdate = true;
    this.#fan.visible = true;
  }

  showFan(isShown) {
    this.#fan.visible = isShown && this.#positions.version > 0;
  }
}
