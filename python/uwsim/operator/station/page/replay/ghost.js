// A second flight, shown beside the replayed one: its hull and track in the 3D map and on the chart, and its distance.
import { GLTFLoader, Vector3 } from '../vendor/three.js';
import { attitude } from '../attitude.js';
import { Vessel } from '../map3d/actors.js';
import { drawVessel } from '../views/chart_marks.js';

const COLOUR = '#b06cff';

// The index of the last entry at or before a time; -1 if there is none.
export function lastBefore(times, time_s) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time_s) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

// The pose [x, y, z, qx, qy, qz, qw] at a time: position interpolated, orientation of the last sample; null outside.
export function poseAt({ times_s: times, poses }, time_s) {
  const k = lastBefore(times, time_s);
  if (k < 0 || time_s > times.at(-1)) return null;
  const next = Math.min(k + 1, times.length - 1);
  const share = next > k ? (time_s - times[k]) / (times[next] - times[k]) : 0;
  return poses[k].map((value, axis) => (axis < 3 ? value + share * (poses[next][axis] - value) : value));
}

export class Ghost {
  /** @type {{ flight: string, track: { times_s: number[], poses: number[][] }, times_s: number[], apart_m: number[] } | null} */
  found = null; // { flight, track, times_s, apart_m }
  /** @type {number[] | null} */
  pose = null; // at the current time
  /** @type {import('../map3d/actors.js').Vessel | null} */
  #vessel = null;
  #count = 0;

  constructor(station, scene, chart) {
    this.station = station;
    this.scene = scene;
    this.chart = chart;
    chart.layers.push((context, frame) => this.#chartLayer(context, frame));
  }

  // Show another flight; '' for none. Rejects with the server's message.
  async show(flight) {
    const count = (this.#count += 1);
    this.#drop();
    if (!flight) return;
    const name = encodeURIComponent(flight);
    const found = await (await this.#load(`/flight/ghost/${name}.json`)).json();
    const hull = await (await this.#load(`/flight/hull/${name}.glb`)).arrayBuffer();
    const model = this.scene.scene ? (await new GLTFLoader().parseAsync(hull, '')).scene : null;
    if (count !== this.#count) return;
    this.found = found;
    if (!model) return;
    const vessel = new Vessel();
    vessel.material.color.set(COLOUR);
    vessel.material.emissive.set(COLOUR);
    vessel.material.emissiveIntensity = 0.4;
    vessel.material.transparent = true;
    vessel.material.opacity = 0.55;
    vessel.track.line.material.color.set(COLOUR);
    vessel.setHull(model);
    for (const [x, y, z] of found.track.poses) vessel.track.add(new Vector3(x, y, z));
    vessel.group.visible = false;
    this.#vessel = vessel;
    this.scene.show(vessel.group, vessel.track.line);
  }

  // Move the second flight's vehicle to its pose at a time.
  moveTo(time_s) {
    if (!this.found) return;
    this.pose = poseAt(this.found.track, time_s);
    if (this.#vessel) {
      this.#vessel.group.visible = this.pose !== null;
      if (this.pose) {
        this.#vessel.group.position.fromArray(this.pose);
        this.#vessel.group.quaternion.fromArray(this.pose, 3);
      }
      this.scene.show();
    }
    this.chart.draw();
  }

  // The distance [m] between the two flights at a time; NaN unless both cover it.
  apart(time_s) {
    const { times_s: times = [], apart_m: apart = [] } = this.found ?? {};
    return time_s <= (times.at(-1) ?? -Infinity) + 0.5 ? (apart[lastBefore(times, time_s)] ?? NaN) : NaN;
  }

  async #load(path) {
    const answer = await fetch(this.station.href(path));
    if (!answer.ok) throw new Error((await answer.text()).trim());
    return answer;
  }

  #drop() {
    if (this.#vessel) this.scene.hide(this.#vessel.group, this.#vessel.track.line);
    [this.found, this.pose, this.#vessel] = [null, null, null];
    this.chart.draw();
  }

  #chartLayer(context, frame) {
    if (!this.found) return;
    context.beginPath();
    for (const pose of this.found.track.poses) context.lineTo(...frame.at(pose));
    context.strokeStyle = COLOUR;
    context.lineWidth = 2;
    context.setLineDash([2, 4]);
    context.stroke();
    context.setLineDash([]);
    if (this.pose) drawVessel(context, frame.at(this.pose), attitude(this.pose.slice(3)).heading_deg, COLOUR);
  }
}
