// The live map in 3D: chunks of points, rebuilt when they change, and coarser when the machine is slow or they are far.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  GLSL3,
  Group,
  Points,
  RawShaderMaterial,
  Sphere,
  Vector3,
} from '../vendor/three.js';
import { BLOCK_EDGE } from '../wire/messages.js';
import { bake, CHUNK_BLOCKS, CHUNK_CELLS, LEVELS } from './voxel_bake.js';

const BAKE_MS = 8; // per frame
export const RAMP = ['#2b4fc0', '#2389cf', '#22bfae', '#86d86a', '#ffe066']; // deep to shallow; sRGB, as the shader writes it

const VERTEX = `
uniform mat4 projectionMatrix, modelViewMatrix;
uniform float edge, pointScale, base, low, high;
uniform vec3 ramp[5];
in vec4 position; // x, y, z and shade, one byte each
out vec3 colour;
void main() {
  vec4 seen = modelViewMatrix * vec4((position.xyz + 0.5) * edge, 1.0);
  gl_Position = projectionMatrix * seen;
  gl_PointSize = clamp(pointScale * edge / max(-seen.z, 0.1), 1.0, 64.0);
  float height = clamp((base + position.z * edge - low) / max(high - low, 0.1), 0.0, 1.0) * 4.0;
  int k = min(int(height), 3);
  colour = mix(ramp[k], ramp[k + 1], height - float(k)) * (0.35 + 0.65 * position.w / 255.0);
}`;
const FRAGMENT = `
precision mediump float;
in vec3 colour;
out vec4 shown;
void main() { shown = vec4(colour, 1.0); }`;

export class VoxelPoints {
  group = new Group();
  bias = 0; // levels that are left out in all chunks
  #chunks = new Map(); // 'x,y,z': { at, blocks: Set, level, wanted, isDirty, points }
  #shared = {
    pointScale: { value: 1 },
    low: { value: -40 },
    high: { value: -10 },
    ramp: { value: RAMP.map((text) => new Color(text).convertLinearToSRGB()) },
  };
  #centre = new Vector3();

  constructor(store) {
    this.store = store;
  }

  get pointCount() {
    let sum = 0;
    for (const { points } of this.#chunks.values()) sum += points?.geometry.attributes.position.count ?? 0;
    return sum;
  }

  setRange(low, high) {
    [this.#shared.low.value, this.#shared.high.value] = [low, high];
  }

  clear() {
    for (const chunk of this.#chunks.values()) this.#drop(chunk);
    this.#chunks.clear();
  }

  changed(blocks) {
    for (const block of blocks) {
      const at = [block.x, block.y, block.z].map((k) => Math.floor(k / CHUNK_BLOCKS) * CHUNK_BLOCKS);
      const key = at.join();
      let chunk = this.#chunks.get(key);
      if (!chunk) {
        chunk = { at, blocks: new Set(), level: 0, points: null };
        this.#chunks.set(key, chunk);
      }
      chunk.blocks.add(block);
      chunk.isDirty = true;
    }
  }

  // Choose levels for this camera, and rebuild changed chunks, the nearest first, within the time of a frame.
  update(camera, heightPx) {
    const edge = this.store.resolution_m;
    if (!edge) return false;
    const pxPerMetreAt1 = heightPx / (2 * Math.tan((camera.fov * Math.PI) / 360));
    this.#shared.pointScale.value = 1.35 * pxPerMetreAt1;
    const waiting = [];
    for (const chunk of this.#chunks.values()) {
      this.#centre
        .fromArray(chunk.at)
        .addScalar(CHUNK_BLOCKS / 2)
        .multiplyScalar(BLOCK_EDGE * edge);
      chunk.distance = Math.max(camera.position.distanceTo(this.#centre) - 0.7 * CHUNK_CELLS * edge, 1);
      const voxelPx = (pxPerMetreAt1 * edge) / chunk.distance;
      chunk.wanted = Math.min(LEVELS - 1, this.bias + Math.max(0, Math.floor(Math.log2(1.5 / voxelPx))));
      if (chunk.isDirty || chunk.wanted !== chunk.level) waiting.push(chunk);
    }
    waiting.sort((a, b) => a.distance - b.distance);
    const end = performance.now() + BAKE_MS;
    for (const chunk of waiting) {
      this.#bake(chunk, edge);
      if (performance.now() > end) break;
    }
    return waiting.length > 0;
  }

  #bake(chunk, edge) {
    this.#drop(chunk);
    [chunk.level, chunk.isDirty] = [chunk.wanted, false];
    const data = bake(chunk.blocks, chunk.at, chunk.level);
    if (data.length === 0) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(data, 4));
    const cell = edge * 2 ** chunk.level;
    const half = 0.5 * CHUNK_CELLS * edge;
    geometry.boundingSphere = new Sphere(new Vector3(half, half, half), half * Math.sqrt(3));
    const [x, y, z] = chunk.at.map((k) => k * BLOCK_EDGE * edge);
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { ...this.#shared, edge: { value: cell }, base: { value: z } },
    });
    chunk.points = new Points(geometry, material);
    chunk.points.position.set(x, y, z);
    chunk.points.matrixAutoUpdate = false;
    chunk.points.updateMatrix();
    this.group.add(chunk.points);
  }

  #drop(chunk) {
    if (!chunk.points) return;
    this.group.remove(chunk.points);
    chunk.points.geometry.dispose();
    chunk.points.material.dispose();
    chunk.points = null;
  }
}
