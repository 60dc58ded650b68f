// The 3D view: the lake, the live map, the vehicle with its track and sonar fan; drawn when pictures leave time for it.
import {
  Color,
  DirectionalLight,
  GLTFLoader,
  HemisphereLight,
  Mesh,
  MeshLambertMaterial,
  OrbitControls,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from '../vendor/three.js';
import { el, grouped, write } from '../dom.js';
import { Marks, Vessel } from './actors.js';
import { FrameGate } from './frame_gate.js';
import { Quality } from './quality.js';
import { crosses } from './sight.js';
import { makeSurface, makeTerrain } from './terrain.js';
import { sceneTools } from './tools.js';
import { VoxelPoints } from './voxel_points.js';
import { VoxelStore } from './voxel_store.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.scene;

const SMALL_MS = 1000; // between two frames while the view is small
const IDLE_MS = 250; // while it is large and does not turn
const LOOK_MS = 300; // between two looks for what hides the vehicle
const FADED = 0.2; // opacity of what hides it

export class SceneView {
  name = 'scene';
  kind = 'scene';
  title = WORDS.title;
  store = new VoxelStore();
  voxels = new VoxelPoints(this.store);
  vessels = new Map(); // name: Vessel
  marks = new Marks();
  quality = new Quality();
  isOrbiting = false;
  #isLarge = false;
  #layers = { terrain: true, map: true, track: true, fan: true, follows: true };
  #isDue = true;
  #drawnMs = -Infinity;
  #lookedMs = -Infinity;
  #scenery = [];
  /** @type {ReturnType<typeof makeTerrain> | null} */
  #terrain = null;
  /** Undefined without WebGL 2, as are the camera, its controls and the renderer.
   * @type {import('three').Scene}
   */
  scene;
  /** @type {import('three').PerspectiveCamera} */
  camera;
  /** @type {OrbitControls} */
  controls;
  /** @type {import('three').WebGLRenderer} */
  renderer;
  /** @type {FrameGate} */
  gate;
  #followed = '';
  #lookAngle = 0; // from behind the vehicle, at which nothing hides it [rad]
  #hasLooked = false; // whether the camera has been aimed at the vehicle's first pose

  constructor() {
    this.canvas = el('canvas', {
      role: 'img',
      'aria-label': WORDS.picture,
      tabindex: '-1',
    });
    this.note = el('p', { className: 'scene-note' });
    const buttons = sceneTools(
      this.#layers,
      () => this.#applyLayers(),
      (isFromAbove) => this.look(isFromAbove),
    );
    this.tools = el('div', { className: 'scene-tools', role: 'group', 'aria-label': WORDS.tools }, ...buttons);
    this.element = [this.canvas, this.tools, this.note];
    this.#makeScene();
    requestAnimationFrame(() => this.#frame());
  }

  get frame_ms() {
    return this.gate?.frame_ms ?? NaN;
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    this.#isDue = true;
    if (this.controls) this.controls.enabled = isLarge;
    this.canvas.tabIndex = isLarge ? 0 : -1;
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
    this.#lookAngle = free?.look_rad ?? 0;
    if (this.#hasLooked && this.#lookAngle) this.look(false);
    this.#isDue = true;
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

  // Add parts to the scene, or redraw those that have moved.
  show(...parts) {
    if (parts.length) this.scene?.add(...parts);
    this.#isDue = true;
  }

  hide(...parts) {
    this.scene?.remove(...parts);
    this.#isDue = true;
  }

  follow(name) {
    this.#followed = name;
  }

  showMap(changes) {
    if (changes.snapshot) this.voxels.clear();
    this.voxels.changed(this.store.apply(changes));
    this.#isDue = true;
  }

  showTelemetry(name, message) {
    const vessel = this.vessels.get(name);
    if (!vessel) return;
    const before = vessel.group.position.clone();
    vessel.move(message);
    if (name === this.#followed && this.#layers.follows) this.#moveWith(vessel.group.position, before);
    this.#isDue = true;
  }

  showScan(name, scan, tilt_rad) {
    this.vessels.get(name)?.setFan(scan, tilt_rad);
    this.#applyLayers();
    this.#isDue = true;
  }

  // Draw a pole at each note's position.
  showNotes(notes) {
    this.marks.clear();
    for (const { position_m } of notes) this.marks.add(position_m);
    this.#isDue = true;
  }

  // Return the view redrawn now, since a WebGL canvas keeps its picture only for one frame.
  picture(take) {
    if (!this.scene) return;
    this.#draw();
    take(this.canvas);
  }

  // Look at the followed vehicle from behind and above, or at the whole map from above.
  look(isFromAbove) {
    const vessel = this.vessels.get(this.#followed);
    const target = vessel ? vessel.group.position : new Vector3(0, 0, -20);
    const ahead = vessel ? new Vector3(1, 0, 0).applyQuaternion(vessel.group.quaternion) : new Vector3(0, 1, 0);
    const away = isFromAbove
      ? new Vector3(0, -0.1, 130)
      : new Vector3(-34 * ahead.x, -34 * ahead.y, 24).applyAxisAngle(new Vector3(0, 0, 1), this.#lookAngle);
    this.#lookAngle = 0; // at the start alone: in flight, the view is from behind
    this.controls.target.copy(target);
    this.camera.position.copy(target).add(away);
    this.controls.update();
    this.#isDue = true;
  }

  #makeScene() {
    try {
      this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: false, powerPreference: 'low-power' });
    } catch {
      write(this.note, WORDS.noWebGl);
      return;
    }
    this.gate = new FrameGate(this.renderer.getContext());
    this.scene = new Scene();
    this.scene.background = new Color(0x0a1720);
    this.camera = new PerspectiveCamera(50, 16 / 9, 0.5, 2000);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-60, -60, 40);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.maxPolarAngle = 0.95 * Math.PI;
    this.controls.minDistance = 2;
    this.controls.maxDistance = 900;
    this.controls.listenToKeyEvents?.(this.canvas);
    this.controls.addEventListener('change', () => {
      this.#isDue = true;
    });
    this.controls.addEventListener('start', () => {
      this.isOrbiting = true;
    });
    this.controls.addEventListener('end', () => {
      this.isOrbiting = false;
    });
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(-0.5, 0.6, 1);
    this.scene.add(new HemisphereLight(0xcfe6f2, 0x1c2f3a, 1.4), sun, this.voxels.group, this.marks.group);
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
    this.#isDue = true;
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

  #frame() {
    requestAnimationFrame(() => this.#frame());
    if (!this.scene || document.hidden || !this.gate.isOpen) return;
    const waited = performance.now() - this.#drawnMs;
    const period = this.#isLarge
      ? this.isOrbiting
        ? 0
        : this.#isDue
          ? Math.max(50, 1.5 * this.gate.frame_ms)
          : IDLE_MS
      : SMALL_MS;
    if (waited < period || (!this.#isDue && !this.isOrbiting)) return;
    this.#draw();
  }

  #fit(width, height) {
    const { ratio } = this.quality;
    if (this.canvas.width === Math.floor(width * ratio) && this.canvas.height === Math.floor(height * ratio)) return;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
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

  #draw() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0 || height === 0) return;
    if (this.#isLarge) this.quality.adapt(this.gate.frame_ms);
    this.#fit(width, height);
    if (performance.now() - this.#lookedMs > LOOK_MS) this.#fade();
    this.voxels.bias = this.quality.bias;
    this.#isDue = this.voxels.update(this.camera, this.canvas.height);
    this.gate.begin();
    this.renderer.render(this.scene, this.camera);
    this.gate.end();
    this.#drawnMs = performance.now();
    write(
      this.note,
      WORDS.drawn(grouped(this.store.count), grouped(this.voxels.pointCount), Math.round(this.gate.frame_ms)),
    );
  }
}

// A fixed mesh in its material's colour (albedo, linear), or else in that of its kind.
function dressed(node, label, albedo) {
  const colour = albedo
    ? new Color().fromArray(albedo)
    : new Color(
        /pipe/.test(label) ? 0xb9a27a : /station/.test(label) ? 0xc8ced2 : /gate/.test(label) ? 0xd98c5f : 0x94a3ad,
      );
  node.traverse((part) => {
    if (part instanceof Mesh) part.material = new MeshLambertMaterial({ color: colour });
  });
  return node;
}
