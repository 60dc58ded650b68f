// The scenario's loose bodies at their true poses, in the 3D view and on the chart.
import { GLTFLoader, Quaternion, Vector3 } from '../vendor/three.js';
import { label } from '../views/chart_marks.js';
import { dressed } from './scene.js';

const LABEL_PX = 12; // above a body

/** @typedef {{ name: string, corners: Vector3[], node: any, position: Vector3 | null, turn: Quaternion }} Body */

export class LooseObjects {
  /** @type {Map<string, Body>} */
  #bodies = new Map();
  #begun = 0;

  constructor(scene, chart) {
    this.scene = scene;
    chart.layers.push((context, frame, isLarge, colours) => this.#draw(context, frame, isLarge, colours));
  }

  // Show another simulator's bodies. load(path): fetches from it.
  async begin(load, { scene: sceneUrl, objects: topic }) {
    const begun = (this.#begun += 1);
    this.scene.hide(...[...this.#bodies.values()].flatMap(({ node }) => node ?? []));
    this.#bodies.clear();
    if (!topic) return;
    const { objects } = await (await load(sceneUrl)).json();
    const loader = new GLTFLoader();
    for (const { name, label: kind, url, colour, corners_m } of objects) {
      const glb = this.scene.scene ? await (await load(url)).arrayBuffer() : null;
      const node = glb ? dressed((await loader.parseAsync(glb, '')).scene, kind, colour) : null;
      if (begun !== this.#begun) return;
      const corners = corners_m.map((corner) => new Vector3(...corner));
      this.#bodies.set(name, { name, corners, node, position: null, turn: new Quaternion() });
    }
  }

  // message: the transforms of bodies.
  show({ transforms }) {
    for (const { child_frame_id: name, transform } of transforms) {
      const body = this.#bodies.get(name);
      if (!body) continue;
      const { translation: at, rotation: turn } = transform;
      if (!body.position && body.node) this.scene.show(body.node);
      body.position = new Vector3(at.x, at.y, at.z);
      body.turn.set(turn.x, turn.y, turn.z, turn.w);
      body.node?.position.copy(body.position);
      body.node?.quaternion.copy(body.turn);
    }
    this.scene.redraw();
  }

  // The outlines of the bodies from above, by name.
  outlines() {
    return [...this.#bodies.values()].flatMap(({ name, corners, position, turn }) => {
      if (!position) return [];
      const points = corners.map((corner) => corner.clone().applyQuaternion(turn).add(position));
      return [{ name, outline: hull(points.map(({ x, y }) => /** @type {[number, number]} */ ([x, y]))) }];
    });
  }

  #draw(c, frame, isLarge, colours) {
    for (const { name, outline } of this.outlines()) {
      c.beginPath();
      for (const point of outline) c.lineTo(...frame.at(point));
      c.closePath();
      c.fillStyle = c.strokeStyle = colours.obstacle;
      c.globalAlpha = 0.5;
      c.lineWidth = 1.4;
      c.fill();
      c.globalAlpha = 1;
      c.stroke();
      if (!isLarge) continue;
      const pixels = outline.map((point) => frame.at(point));
      const middle = pixels.reduce((sum, [x]) => sum + x, 0) / pixels.length;
      label(c, name.replaceAll('_', ' '), middle, Math.min(...pixels.map(([, y]) => y)) - LABEL_PX, colours);
    }
  }
}

/** The corners of the convex hull of points (Andrew 1979, doi:10.1016/0020-0190(79)90072-3).
 * @type {(points: [number, number][]) => [number, number][]}
 */
export function hull(points) {
  const sorted = points.toSorted(([a, b], [c, d]) => a - c || b - d);
  return sorted.length < 3 ? sorted : [...half(sorted), ...half(sorted.toReversed())];
}

function half(sorted) {
  /** @type {[number, number][]} */
  const found = [];
  for (const point of sorted) {
    while (found.length > 1 && !isLeft(found[found.length - 2], found[found.length - 1], point)) found.pop();
    found.push(point);
  }
  return found.slice(0, -1);
}

const isLeft = ([x0, y0], [x1, y1], [x, y]) => (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0;
