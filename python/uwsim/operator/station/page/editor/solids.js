// The nodes by which the editor's 3D view shows each part: its solid, its corners, or a mark in its direction.
import {
  BufferAttribute,
  BufferGeometry,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Vector3,
} from '../vendor/three.js';
import { faceted } from '../map3d/terrain.js';
import { STARTS, cornersOf, placeOf, yawOf } from './geometry.js';

const [PLAIN, CHOSEN, VESSEL, LINE, MARK] = [0xb9c4cc, 0xff9d5c, 0xffd166, 0x8fd3ff, 0xffffff];
const SOLID = new Set(['obstacles', 'props']); // sections that come first, of parts with a solid
const ABOARD_M = 15; // from the camera, within which parts aboard are shown
const MARK_PX = 9; // half the size of a mark
const MARKED = new Set([...STARTS, 'objects', 'life', 'goals']); // sections of parts without a solid
const RAD = Math.PI / 180;

const lambert = (color) => new MeshLambertMaterial({ color, emissive: color, emissiveIntensity: 0.15 });
const painted = (emissive, emissiveIntensity) =>
  new MeshLambertMaterial({ vertexColors: true, emissive, emissiveIntensity });
const keyOf = ({ values }) => JSON.stringify(values);

/** @typedef {{ key: string, node: any }} Solid */

export class PartSolids {
  group = new Group();
  #parts;
  #redraw;
  /** @type {(Solid | undefined)[]} */
  #solids = []; // by the indices of their parts
  /** @type {any[]} */
  #marks = []; // scaled with the distance
  #drawn = new Group(); // all but the solids
  /** @type {any} */
  #bed = null;
  #materials = {
    plain: lambert(PLAIN),
    chosen: lambert(CHOSEN),
    own: painted(PLAIN, 0.05),
    ownChosen: painted(CHOSEN, 0.3),
    vessel: lambert(VESSEL),
    line: new LineBasicMaterial({ color: LINE }),
    chosenLine: new LineBasicMaterial({ color: CHOSEN }),
    mark: new LineBasicMaterial({ color: MARK }),
  };
  #cone = makeCone();
  #cross = makeCross();

  /** @param {import('./parts.js').EditedParts} parts */
  constructor(parts, redraw) {
    [this.#parts, this.#redraw] = [parts, redraw];
    this.group.add(this.#drawn);
  }

  // geometry: of the bed, whose points are a grid.
  ground(geometry) {
    this.#bed = geometry.attributes.position.array;
    this.show();
  }

  /** The height of the bed at the point of its grid that is nearest to a place.
   * @param {number[]} place
   */
  bedAt([x, y]) {
    let [found, nearest] = [0, Infinity];
    for (let k = 0; k < (this.#bed?.length ?? 0); k += 3) {
      const away = (this.#bed[k] - x) ** 2 + (this.#bed[k + 1] - y) ** 2;
      if (away < nearest) [found, nearest] = [this.#bed[k + 2], away];
    }
    return found;
  }

  // Load the solids that have changed. fetchSolid(path): returns one as a node.
  load({ files, plan, parts }, fetchSolid) {
    const solids = parts.filter(({ section }) => SOLID.has(section));
    const known = new Map(this.#solids.flatMap((each) => (each ? [[each.key, each]] : [])));
    const old = this.#solids;
    this.#solids = solids.map((part, k) => {
      const key = keyOf(part);
      if (known.has(key)) return known.get(key);
      this.#fetch(k, key, () => fetchSolid(`${files}/${plan}/${k}.glb`));
      return old.length === solids.length ? old[k] : undefined; // until the new one has come
    });
    this.show();
  }

  async #fetch(k, key, fetchSolid) {
    const node = await fetchSolid().catch(() => null); // empty if of an edition that is no more: a newer one is under way
    if (!node || keyOf(this.#parts.list[k] ?? { values: null }) !== key) return;
    this.#solids[k] = { key, node: wrapped(node) };
    this.show();
  }

  // True if each solid is shown as it is now, and can be pointed at.
  get isWhole() {
    return this.#parts.list.every((part, k) => !SOLID.has(part.section) || this.#solids[k]?.key === keyOf(part));
  }

  // Nodes of the solids, each with the index of its part.
  *nodes() {
    for (const [k, solid] of this.#solids.entries()) if (solid) yield /** @type {[number, any]} */ ([k, solid.node]);
  }

  // The place of a part, its height included; null if it has none.
  placeOf(index) {
    const part = this.#parts.at(index);
    const place = part && placeOf(part, this.#parts.fieldsOf(part));
    return place ? new Vector3(place[0], place[1], this.#heightOf(part, place)) : null;
  }

  // The place of a part's mark; null for one that is not shown, or is shown by its solid.
  markOf(index) {
    const mark = this.#marks.find(({ userData }) => userData.index === index);
    return mark?.visible ? mark.position : null;
  }

  // The corners of the chosen part.
  cornersOf(index) {
    const part = this.#parts.list[index] && this.#parts.at(index);
    if (!part) return [];
    const rows = this.#rowsOf(part);
    return cornersOf(part, this.#parts.fieldsOf(part)).map(
      ([x, y], k) => new Vector3(x, y, rows[k]?.[2] ?? (part.section === 'survey' ? 0 : this.bedAt([x, y]))),
    );
  }

  #rowsOf(part) {
    const line = this.#parts.fieldsOf(part).find(({ role }) => role === 'line');
    const isInWorld = line?.columns[2] === 'z';
    return isInWorld ? (part.values[line.name] ?? []) : [];
  }

  #heightOf(part, place) {
    const field = this.#parts.fieldsOf(part).find(({ role }) => role === 'place');
    const own = field && (part.values[field.name] ?? field.by_default);
    const z = Array.isArray(own) && own.length > 2 ? own[2] : NaN;
    const isOnBed = part.values.on_bed ?? part.values['shape.on_bed'];
    if (part.section === 'obstacles' || isOnBed) return isOnBed || Number.isNaN(z) ? this.bedAt(place) + (z || 0) : z;
    return Number.isNaN(z) ? 0 : z + (part.frame[3] ?? 0);
  }

  show() {
    const { list, selected, mark } = this.#parts;
    this.group.clear();
    this.#drawn.clear();
    this.#marks = [];
    this.group.add(this.#drawn);
    list.forEach((part, k) => {
      const solid = SOLID.has(part.section) ? this.#solids[k] : undefined;
      if (solid) this.#showSolid(solid.node, k, k === selected);
      this.#showLines(k, k === selected);
      if (part.vehicle !== null || MARKED.has(part.section)) this.#showMark(k, k === selected);
    });
    if (mark) this.#add(new LineSegments(this.#cross, this.#materials.mark), [...mark, this.bedAt(mark)], -1);
    this.#redraw();
  }

  // Show a solid, moved and turned with the changes that are not yet sent.
  #showSolid(node, index, isChosen) {
    const [old, part] = [this.#parts.list[index], this.#parts.at(index)];
    const fields = this.#parts.fieldsOf(part);
    const [from, to] = [placeOf(old, fields), placeOf(part, fields)];
    const turn = ((yawOf(part, fields) ?? 0) - (yawOf(old, fields) ?? 0)) * RAD;
    node.rotation.z = turn;
    node.position.set(0, 0, 0);
    if (from && to) {
      const [c, s] = [Math.cos(turn), Math.sin(turn)];
      const rise = (part.values.position_m?.[2] ?? 0) - (old.values.position_m?.[2] ?? 0);
      node.position.set(to[0] - c * from[0] + s * from[1], to[1] - s * from[0] - c * from[1], rise);
    }
    node.traverse((each) => {
      if (each.isMesh) each.material = isChosen ? this.#materials.ownChosen : this.#materials.own;
    });
    this.group.add(node);
  }

  #showLines(index, isChosen) {
    const part = this.#parts.list[index];
    if (!isChosen && part.section !== 'survey') return;
    const corners = this.cornersOf(index);
    if (corners.length < 2) return;
    const points = part.section === 'survey' ? [...corners, corners[0]] : corners;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(points.flatMap((p) => p.toArray())), 3));
    this.#drawn.add(new Line(geometry, isChosen ? this.#materials.chosenLine : this.#materials.line));
    if (isChosen) for (const corner of corners) this.#add(this.#knob(), corner.toArray(), -1);
  }

  #showMark(index, isChosen) {
    const place = this.placeOf(index);
    if (!place) return;
    const part = this.#parts.at(index);
    const isStart = STARTS.has(part.section);
    const cone = new Mesh(
      this.#cone,
      isChosen ? this.#materials.chosen : this.#materials[isStart ? 'vessel' : 'plain'],
    );
    cone.rotation.z = (yawOf(part, this.#parts.fieldsOf(part)) ?? 0) * RAD;
    cone.userData.isAboard = part.vehicle !== null && !isStart && !isChosen;
    cone.userData.isStart = isStart;
    this.#add(cone, place.toArray(), index);
  }

  #knob() {
    return new Mesh(this.#cone, this.#materials.chosen);
  }

  #add(node, place, index) {
    node.position.fromArray(place);
    node.userData.index = index;
    this.#marks.push(node);
    this.#drawn.add(node);
  }

  // Give the marks the same size on the screen at any distance, and hide parts aboard that are far.
  scale(camera, height) {
    const perMetre = height / (2 * Math.tan((camera.fov * Math.PI) / 360)); // pixels of a metre, one metre away
    for (const mark of this.#marks) {
      const away = camera.position.distanceTo(mark.position);
      mark.scale.setScalar(((mark.userData.isStart ? 1.6 : 0.8) * MARK_PX * away) / perMetre);
      mark.visible = !mark.userData.isAboard || away < ABOARD_M;
    }
  }
}

// A solid in world coordinates, below a node that moves it.
function wrapped(node) {
  const found = new Group();
  node.traverse((each) => {
    if (each.isMesh) faceted(each);
  });
  found.add(node);
  return found;
}

// A cone along x, its tip ahead.
function makeCone() {
  const sides = [
    [-0.8, 0.6, 0.6],
    [-0.8, -0.6, 0.6],
    [-0.8, -0.6, -0.6],
    [-0.8, 0.6, -0.6],
  ];
  const tip = [1.2, 0, 0];
  const back = [sides[0], sides[2], sides[1], sides[0], sides[3], sides[2]];
  const faces = sides.flatMap((side, k) => [side, sides[(k + 1) % 4], tip]);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array([...faces, ...back].flat()), 3));
  geometry.computeVertexNormals();
  return geometry;
}

// Three crossed lines: the point at which a part is added.
function makeCross() {
  const lines = [-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 2];
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(lines), 3));
  return geometry;
}
