// The 3D view: the lake, the live map, the vehicle with its track and sonar fan.
import { Color, GLTFLoader, Mesh, MeshLambertMaterial, Vector3 } from '../vendor/three.js';
import { el } from '../dom.js';
import { Marks, Vessel } from './actors.js';
import { crosses } from './sight.js';
import { Stage } from './stage.js';
import { faceted, makeSurface, makeTerrain } from './terrain.js';
import { sceneTools } from './tools.js';

const LOOK_MS = 300; // between two looks for what hides the vehicle
const FADED = 0.2; // opacity of what hides it

export class SceneView extends Stage {
  name = 'scene';
  kind = 'scene';
  title = '3D map';
  vessels = new Map(); // name: Vessel
  marks = new Marks();
  #layers = { terrain: true, map: true, track: true, fan: true, follows: true };
  #lookedMs = -Infinity;
  #scenery = [];
  /** @type {ReturnType<typeof makeTerrain> | null} */
  #terrain = null;
  #followed = '';
  /** From the vehicle at its start to an eye from which nothing hides it [m].
   * @type {number[] | null}
   */
  #firstLook = null;
  #hasLooked = false; // whether the camera has been aimed at the vehicle's first pose

  constructor() {
    super('3D view of the lake, the map and the vehicle');
    const buttons = sceneTools(
      this.#layers,
      () => this.#applyLayers(),
      (isFromAbove) => this.look(isFromAbove),
    );
    this.tools = el('div', { className: 'scene-tools', role: 'group', 'aria-label': '3D view' }, ...buttons);
    this.element = [this.canvas, this.tools, this.note];
    this.show(this.marks.group);
  }

  // Show another simulator's lake. load(path): fetches from it; sceneUrl: its scene.json, '' if no server offers one.
  async begin(load, vehicles, sceneUrl) {
    this.clear();
    for (const part of this.#scenery) this.scene?.remove(part);
    this.#scenery = [];
    if (!this.scene) return;
    for (const { name } of vehicles) this.#addVessel(name);
    this.#followed = vehicles[0]?.name ?? '';
    if (!sceneUrl) return;
    const found = await (await load(sceneUrl)).json();
    const heights = new Float32Array(await (await load(found.terrain.url)).arrayBuffer());
    this.#terrain = makeTerrain(heights, found.terrain, 0.5);
    this.voxels.setRange(this.#terrain.low_m, this.#terrain.high_m);
    this.#addScenery(this.#terrain.mesh, makeSurface(found.terrain, found.surface_m ?? 0));
    const loader = new GLTFLoader();
    const glb = async (url) => (await loader.parseAsync(await (await load(url)).arrayBuffer(), '')).scene;
    for (const { url, label, colour } of found.meshes) this.#addScenery(dressed(await glb(url), label, colour));
    for (const { name, url } of found.vehicles) this.vessels.get(name)?.setHull(await glb(url));
    const free = found.vehicles.find(({ name }) => name === this.#followed);
    this.#firstLook = free?.look_m ?? null;
    if (this.#hasLooked && this.#firstLook) this.look(false);
    this.redraw();
  }

  // Clear the map and the tracks, for example at a restart.
  clear() {
    this.#hasLooked = false;
    this.store.clear();
    this.voxels.clear();
    for (const { group, track } of this.vessels.values()) this.scene?.remove(group, track.line);
    this.vessels.clear();
    this.marks.clear();
  }

  follow(name) {
    this.#followed = name;
  }

  showTelemetry(name, message) {
    const vessel = this.vessels.get(name);
    if (!vessel) return;
    const before = vessel.group.position.clone();
    vessel.move(message);
    if (name === this.#followed && this.#layers.follows) this.#moveWith(vessel.group.position, before);
    this.redraw();
  }

  showScan(name, scan, tilt_rad) {
    this.vessels.get(name)?.setFan(scan, tilt_rad);
    this.#applyLayers();
    this.redraw();
  }

  // Draw a pole at each note's position.
  showNotes(notes) {
    this.marks.clear();
    for (const { position_m } of notes) this.marks.add(position_m);
    this.redraw();
  }

  // Look at the followed vehicle from behind and above, or at the whole map from above.
  look(isFromAbove) {
    const vessel = this.vessels.get(this.#followed);
    const target = vessel ? vessel.group.position : new Vector3(0, 0, -20);
    const ahead = vessel ? new Vector3(1, 0, 0).applyQuaternion(vessel.group.quaternion) : new Vector3(0, 1, 0);
    const away = isFromAbove
      ? new Vector3(0, -0.1, 130)
      : new Vector3(...(this.#firstLook ?? [-34 * ahead.x, -34 * ahead.y, 24]));
    this.#firstLook = null; // at the start alone: in flight, the view is from behind
    this.aim(target.clone().add(away), target);
  }

  #addVessel(name) {
    const vessel = new Vessel();
    this.vessels.set(name, vessel);
    this.scene.add(vessel.group, vessel.track.line);
  }

  #addScenery(...parts) {
    this.#scenery.push(...parts);
    this.scene.add(...parts);
    this.#applyLayers();
  }

  #applyLayers() {
    if (this.#terrain) this.#terrain.mesh.visible = this.#layers.terrain;
    this.voxels.group.visible = this.#layers.map;
    for (const vessel of this.vessels.values()) {
      vessel.track.line.visible = this.#layers.track;
      vessel.showFan(this.#layers.fan);
    }
    this.redraw();
  }

  #moveWith(now, before) {
    if (!this.controls) return;
    if (!this.#hasLooked) {
      this.#hasLooked = true;
      this.look(false);
      return;
    }
    const moved = now.clone().sub(before);
    this.controls.target.add(moved);
    this.camera.position.add(moved);
  }

  // Fade the meshes that stand before the followed vehicle.
  #fade() {
    this.#lookedMs = performance.now();
    const vessel = this.vessels.get(this.#followed);
    if (!vessel) return;
    const [from, to] = [this.camera.position.toArray(), vessel.group.position.toArray()];
    for (const node of this.#scenery)
      node.traverse((part) => {
        if (!(part instanceof Mesh) || !(part.material instanceof MeshLambertMaterial)) return;
        const { position } = part.geometry.attributes;
        const hides = crosses(position.array, part.geometry.index?.array ?? null, from, to);
        part.material.transparent = hides;
        part.material.opacity = hides ? FADED : 1;
        part.material.depthWrite = !hides;
      });
  }

  beforeDraw() {
    if (performance.now() - this.#lookedMs > LOOK_MS) this.#fade();
  }
}

// A mesh in its own colours, else in its material's (albedo, linear), else in that of its kind.
export function dressed(node, label, albedo) {
  const colour = albedo
    ? new Color().fromArray(albedo)
    : new Color(
        /pipe/.test(label) ? 0xb9a27a : /station/.test(label) ? 0xc8ced2 : /gate/.test(label) ? 0xd98c5f : 0x94a3ad,
      );
  node.traverse((part) => {
    if (!(part instanceof Mesh)) return;
    faceted(part);
    const isColoured = Boolean(part.geometry.attributes.color);
    part.material = new MeshLambertMaterial(isColoured ? { vertexColors: true } : { color: colour });
  });
  return node;
}
