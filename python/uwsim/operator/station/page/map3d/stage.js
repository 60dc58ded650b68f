// A 3D view of a map: its voxels, the camera and its controls; drawn when pictures leave time for it.
import {
  Color,
  DirectionalLight,
  HemisphereLight,
  OrbitControls,
  PerspectiveCamera,
  Scene,
  WebGLRenderer,
} from '../vendor/three.js';
import { el, grouped, write } from '../dom.js';
import { FrameGate } from './frame_gate.js';
import { Quality } from './quality.js';
import { VoxelPoints } from './voxel_points.js';
import { VoxelStore } from './voxel_store.js';

const SMALL_MS = 1000; // between two frames while the view is small
const IDLE_MS = 250; // while it is large and does not turn

export class Stage {
  store = new VoxelStore();
  voxels = new VoxelPoints(this.store);
  quality = new Quality();
  isOrbiting = false;
  #isLarge = false;
  #isDue = true;
  #drawnMs = -Infinity;
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

  // picture: what is seen, for a screen reader.
  constructor(picture) {
    this.canvas = el('canvas', { role: 'img', 'aria-label': picture, tabindex: '-1' });
    this.note = el('p', { className: 'scene-note' });
    this.#makeScene();
    requestAnimationFrame(() => this.#frame());
  }

  get frame_ms() {
    return this.gate?.frame_ms ?? NaN;
  }

  setLarge(isLarge) {
    this.#isLarge = isLarge;
    this.redraw();
    if (this.controls) this.controls.enabled = isLarge;
    this.canvas.tabIndex = isLarge ? 0 : -1;
  }

  redraw() {
    this.#isDue = true;
  }

  // Add parts to the scene, or redraw those that have moved.
  show(...parts) {
    if (parts.length) this.scene?.add(...parts);
    this.redraw();
  }

  hide(...parts) {
    this.scene?.remove(...parts);
    this.redraw();
  }

  showMap(changes) {
    if (changes.snapshot) this.voxels.clear();
    this.voxels.changed(this.store.apply(changes));
    this.redraw();
  }

  // Return the view redrawn now, since a WebGL canvas keeps its picture only for one frame.
  picture(take) {
    if (!this.scene) return;
    this.#draw();
    take(this.canvas);
  }

  // Aim the camera from one point at another.
  aim(from, target) {
    if (!this.controls) return;
    this.controls.target.copy(target);
    this.camera.position.copy(from);
    this.controls.update();
    this.redraw();
  }

  // Called before each frame.
  beforeDraw() {}

  // The text below the picture.
  noted() {
    return `${grouped(this.store.count)} voxels · ${grouped(this.voxels.pointCount)} drawn · ${Math.round(this.gate.frame_ms)} ms`;
  }

  #makeScene() {
    try {
      this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: false, powerPreference: 'low-power' });
    } catch {
      write(this.note, 'This browser has no WebGL 2: no 3D view');
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
    this.controls.addEventListener('change', () => this.redraw());
    this.controls.addEventListener('start', () => {
      this.isOrbiting = true;
    });
    this.controls.addEventListener('end', () => {
      this.isOrbiting = false;
    });
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(-0.5, 0.6, 1);
    this.scene.add(new HemisphereLight(0xcfe6f2, 0x1c2f3a, 1.4), sun, this.voxels.group);
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

  #draw() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0 || height === 0) return;
    if (this.#isLarge) this.quality.adapt(this.gate.frame_ms);
    this.#fit(width, height);
    this.beforeDraw();
    this.voxels.bias = this.quality.bias;
    this.#isDue = this.voxels.update(this.camera, this.canvas.height);
    this.gate.begin();
    this.renderer.render(this.scene, this.camera);
    this.gate.end();
    this.#drawnMs = performance.now();
    write(this.note, this.noted());
  }
}
