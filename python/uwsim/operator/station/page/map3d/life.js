// Schools of fish and plumes of bubbles where they truly are, in the 3D view and on the chart.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Mesh, MeshLambertMaterial } from '../vendor/three.js';
import { label } from '../views/chart_marks.js';

const FISH_PX = 2.5; // of a fish or cluster on the chart
const LABEL_PX = 12; // above a swarm
const BALL = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]; // prettier-ignore
const SIDES = [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5];
const SHAPES = {
  fish: {
    corners: [[0.5, 0, 0], [0, 0.07, 0], [-0.34, 0, 0], [0, -0.07, 0], [0, 0, 0.13], [0, 0, -0.13], [-0.5, 0, 0.12], [-0.5, 0, -0.12]], // prettier-ignore
    faces: [...SIDES, 2, 6, 7], // with a tail
  },
  bubbles: { corners: BALL.map((corner) => corner.map((value) => 0.5 * value)), faces: SIDES },
};

class Swarm {
  /** @type {number[][]} */
  places = []; // of each: x, y, z, and a unit vector ahead

  constructor({ name, kind, drawn, size_m, colour }) {
    const { corners, faces } = SHAPES[kind];
    this.name = name;
    this.drawn = drawn;
    this.corners = corners.map((corner) => corner.map((value) => size_m * value));
    this.colour = new Color().fromArray(colour);
    const index = Array.from({ length: drawn }, (_, k) => faces.map((corner) => corner + k * corners.length)).flat();
    this.geometry = new BufferGeometry();
    this.geometry.setIndex(index);
    this.geometry.setAttribute('position', new BufferAttribute(new Float32Array(3 * drawn * corners.length), 3));
    const material = new MeshLambertMaterial({ color: this.colour, flatShading: true, side: DoubleSide });
    this.mesh = new Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
  }

  move(places) {
    this.places = places;
    const { position } = this.geometry.attributes;
    let k = 0;
    for (const [x, y, z, ahead, aside, up] of places) {
      const level = Math.hypot(ahead, aside) || 1;
      const [c, s] = [ahead / level, aside / level]; // heading; its left is (-s, c, 0)
      for (const [a, b, h] of this.corners) {
        position.setXYZ(
          k,
          x + a * ahead - b * s - h * up * c,
          y + a * aside + b * c - h * up * s,
          z + a * up + h * level,
        );
        k += 1;
      }
    }
    position.needsUpdate = true;
  }
}

export class Life {
  /** @type {Swarm[]} */
  #swarms = [];

  constructor(scene, chart) {
    this.scene = scene;
    chart.layers.push((context, frame, isLarge, colours) => this.#draw(context, frame, isLarge, colours));
  }

  // Show another simulator's fish and bubbles; returns the ends of the subscriptions.
  begin(bridge, { life }, options) {
    this.scene.hide(...this.#swarms.map(({ mesh }) => mesh));
    this.#swarms = (life?.swarms ?? []).map((swarm) => new Swarm(swarm));
    if (!life) return [];
    return [bridge.subscribe(life.topic, 'std_msgs/Float32MultiArray', ({ data }) => this.show(data), options)];
  }

  // data: x, y, z and a unit vector ahead of each, swarm by swarm.
  show(data) {
    let first = 0;
    for (const swarm of this.#swarms) {
      if (swarm.places.length === 0) this.scene.show(swarm.mesh);
      swarm.move(Array.from({ length: swarm.drawn }, (_, k) => data.slice(first + 6 * k, first + 6 * k + 6)));
      first += 6 * swarm.drawn;
    }
    this.scene.redraw();
  }

  // The places of those of a swarm that are drawn, for tests.
  placesOf(name) {
    return this.#swarms.find((swarm) => swarm.name === name)?.places.map((place) => Array.from(place)) ?? [];
  }

  #draw(c, frame, isLarge, colours) {
    for (const { name, colour, places } of this.#swarms) {
      if (places.length === 0) continue;
      c.fillStyle = `#${colour.getHexString()}`;
      const pixels = places.map((place) => frame.at(place));
      for (const [x, y] of pixels) c.fillRect(x - FISH_PX / 2, y - FISH_PX / 2, FISH_PX, FISH_PX);
      if (!isLarge) continue;
      const middle = pixels.reduce((sum, [x]) => sum + x, 0) / pixels.length;
      label(c, name.replaceAll('_', ' '), middle, Math.min(...pixels.map(([, y]) => y)) - LABEL_PX, colours);
    }
  }
}
