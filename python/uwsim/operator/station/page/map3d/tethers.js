// The tethers of vehicles and loose bodies in the 3D view and on the chart, coloured by tension.
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments } from '../vendor/three.js';

const MOST = 1024; // elements
const SLACK_N = 1; // and less: the scale's low end
const APART = 1.5; // a broken tether's element of this relative length is the gap between its pieces
const STOPS = [
  [0.25, 0.6, 1],
  [1, 0.9, 0.3],
  [1, 0.15, 0.1],
]; // slack, between, at the breaking load; as panel.css has them for the scale

/** The colour of a tension: its logarithm between 1 N and the breaking load.
 * @type {(tension_n: number, breaking_load_n: number) => number[]}
 */
export function colourOf(tension_n, breaking_load_n) {
  const whole = Math.log(Math.max(tension_n, SLACK_N) / SLACK_N) / Math.log(Math.max(breaking_load_n, 10) / SLACK_N);
  const share = 2 * Math.min(1, whole);
  const [low, high] = share < 1 ? STOPS : STOPS.slice(1);
  return low.map((value, k) => value + (share % 1 || Number(share === 2)) * (high[k] - value));
}

const css = (colour) => `rgb(${colour.map((value) => Math.round(255 * value)).join(' ')})`;

class Drawn {
  positions = new Float32Array(6 * MOST);
  colours = new Float32Array(6 * MOST);
  count = 0;
  points = [];
  tensions = [];
  state = [];

  constructor(tether) {
    this.tether = tether;
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute('position', new BufferAttribute(this.positions, 3));
    this.geometry.setAttribute('color', new BufferAttribute(this.colours, 3));
    this.line = new LineSegments(this.geometry, new LineBasicMaterial({ vertexColors: true }));
    this.line.frustumCulled = false;
  }

  // The elements that are whole: [from, to, colour].
  *elements() {
    const [length_m = 0, , , , isBroken] = this.state;
    const usual_m = length_m / this.tensions.length;
    for (let k = 0; k + 1 < this.points.length && k < MOST; k += 1) {
      const [from, to, tension_n] = [this.points[k], this.points[k + 1], this.tensions[k] ?? 0];
      const apart_m = Math.hypot(...from.map((value, axis) => value - to[axis]));
      if (isBroken && tension_n === 0 && apart_m > APART * usual_m) continue;
      yield [from, to, colourOf(tension_n, this.tether.breaking_load_n)];
    }
  }

  fill() {
    this.count = 0;
    for (const [from, to, colour] of this.elements()) {
      this.positions.set([...from, ...to], 6 * this.count);
      this.colours.set([...colour, ...colour], 6 * this.count);
      this.count += 1;
    }
    this.geometry.setDrawRange(0, 2 * this.count);
    this.geometry.attributes.position.needsUpdate = true;
    this.geometry.attributes.color.needsUpdate = true;
  }
}

export class Tethers {
  /** @type {Map<string, Drawn>} */
  #drawn = new Map();

  constructor(scene, chart) {
    this.scene = scene;
    chart.layers.push((context, frame) => this.#draw(context, frame));
  }

  // Show another simulator's tethers; returns the ends of the subscriptions.
  begin(bridge, { vehicles, tethers }, options) {
    this.scene.hide(...[...this.#drawn.values()].map(({ line }) => line));
    this.#drawn.clear();
    const all = [...vehicles, ...Object.entries(tethers).map(([name, tether]) => ({ name, tether }))];
    return all.flatMap(({ name, tether }) => {
      if (!tether) return [];
      const drawn = new Drawn(tether);
      this.#drawn.set(name, drawn);
      this.scene.show(drawn.line);
      return [
        bridge.subscribe(tether.shape, 'nav_msgs/Path', (message) => this.showShape(drawn, message), options),
        bridge.subscribe(
          tether.tension,
          'std_msgs/Float64MultiArray',
          ({ data }) => {
            drawn.state = data.slice(0, 5);
            drawn.tensions = data.slice(5);
          },
          options,
        ),
      ];
    });
  }

  showShape(drawn, { poses }) {
    const [east, north, up] = drawn.tether.origin_m; // of the world, in odom
    drawn.points = poses.map(({ pose: { position } }) => [position.x + east, position.y + north, position.z + up]);
    drawn.fill();
    this.scene.redraw();
  }

  // The elements of a vehicle's or loose body's tether, for tests: [from, to, colour].
  elementsOf(name) {
    return [...(this.#drawn.get(name)?.elements() ?? [])];
  }

  #draw(c, frame) {
    c.lineWidth = 1.6;
    for (const drawn of this.#drawn.values()) {
      for (const [from, to, colour] of drawn.elements()) {
        c.beginPath();
        c.lineTo(...frame.at(from));
        c.lineTo(...frame.at(to));
        c.strokeStyle = css(colour);
        c.stroke();
      }
    }
  }
}
