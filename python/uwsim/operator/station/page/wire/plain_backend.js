// A rosbridge without a station, such as `uwsim serve lake`: the same requests, answered by ROS topics and services.
// There is no lease, and no server that zeroes the efforts of a closed page, so the page shows a notice.
import { AXES, SERVICES } from './messages.js';
import { seconds } from './rosbridge.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.wire;

const PACE_MS = 500;
const CAMERA = /^\/(?:(\w+)\/)?camera\/(\w+)\/image_raw\/compressed$/;
const TILT = { min_rad: -Math.PI / 2, max_rad: Math.PI / 2, rate_rad_s: (5 * Math.PI) / 180 }; // of the published wire
const FIXED = {
  // functions that are unavailable without a station
  truth_allowed: true,
  warnings: { proximity_m: 10 },
  scene: '',
  commands: [...SERVICES, 'set_lamp', 'aim'],
};

export class PlainBackend {
  isPlain = true;
  #bridge;
  #update;
  #session = 1;
  #time_s = 0;

  // update(state): receives the state in the format of /station/state.
  constructor(bridge, update) {
    [this.#bridge, this.#update] = [bridge, update];
  }

  async join(_name) {
    clearInterval(this.timer);
    this.timer = setInterval(() => this.#ask(), PACE_MS);
    this.#bridge.subscribe(
      '/clock',
      'rosgraph_msgs/Clock',
      ({ clock }) => {
        this.#time_s = seconds(clock);
      },
      { throttle_rate: 200 },
    );
    await this.#ask();
    return { success: /** @type {const} */ (true), message: '', id: 'me' };
  }

  async describe() {
    const [{ topics }, { services }] = await Promise.all([
      this.#bridge.call('/rosapi/topics'),
      this.#bridge.call('/rosapi/services'),
    ]);
    const prefixes = topics
      .filter((name) => /^\/(\w+\/)?telemetry$/.test(name))
      .map((name) => name.slice(1, -'telemetry'.length));
    if (prefixes.length === 0) throw new Error(WORDS.noVehicle);
    const has = (name) => (topics.includes(name) ? name : null);
    /** @type {import('./messages.js').VehicleDescription[]} */
    const vehicles = prefixes.map((prefix) => ({
      name: prefix.slice(0, -1) || 'vehicle',
      prefix,
      telemetry: `/${prefix}telemetry`,
      sensor_gauges: has(`/${prefix}sensor_gauges`),
      scan: has(`/${prefix}scan`),
      link: has(`/${prefix}link`),
      map_changes: has(`/${prefix}map_changes`),
      efforts: AXES,
      tilt: has(`/${prefix}cmd_tilt`) ? TILT : null,
      lamps: services
        .filter((name) => name.startsWith(`/${prefix}lights/`))
        .map((name) => name.split('/').at(-1) ?? ''),
      // parts that a vehicle has only at a station
      model: '',
      joints: null,
      proximities: [],
      map: null,
      pings_per_s: 0,
      thrusters: [],
      droppers: [],
      holds: [],
      sonar: null,
      motors: [],
      tether: null,
      arm: [],
      can_jog: false,
    }));
    const views = topics
      .map((topic) => CAMERA.exec(topic))
      .filter(Boolean)
      .map(([topic, vehicle, name]) => ({
        name: vehicle ? `${vehicle}/${name}` : name,
        title: name.replace(/^./, (letter) => letter.toUpperCase()),
        kind: 'camera',
        topic,
        small_topic: topic,
        vehicle: vehicle ?? '',
      }));
    return {
      success: true,
      ...FIXED,
      session: this.#session,
      scenario: new URL(this.#bridge.url).host,
      vehicles,
      views,
    };
  }

  // A key of the published protocol, whose sway and yaw are to starboard.
  async drive(vehicle, { surge, sway, heave, roll, pitch, yaw }, _stampMs) {
    const prefix = vehicle === 'vehicle' ? '' : `${vehicle}/`;
    this.#bridge.publish(`/${prefix}key`, {
      position: { x: surge, y: -sway, z: heave },
      orientation: { x: pitch, y: roll, z: -yaw, w: 0 },
    });
    return { success: true };
  }

  command(name, vehicle, args) {
    const { lamp, on, elevation_rad } = args;
    const prefix = vehicle === 'vehicle' ? '/' : `/${vehicle}/`;
    if (name === 'set_lamp') return this.#bridge.call(`${prefix}lights/${lamp}`, { data: on });
    if (name !== 'aim') return this.#bridge.call(`${prefix}${name}`, args);
    this.#bridge.publish(`${prefix}cmd_tilt`, { data: -elevation_rad }); // positive is nose down there
    return Promise.resolve({ success: true });
  }

  allStop(vehicle, on) {
    return this.#bridge.call(`${vehicle === 'vehicle' ? '/' : `/${vehicle}/`}all_stop`, { data: on });
  }

  /** @param {string} action
   * @param {{ steps?: number, speed?: number, name?: string }} args
   */
  async control(action, { steps, speed, name }) {
    if (action === 'quit') {
      location.search = '';
      return { success: true };
    }
    const service = { step: 'step', speed: 'set_speed', restart: 'reset' }[action] ?? action;
    const answer =
      action === 'save'
        ? await this.#bridge.call('/save_map', { name: `${name}.bt` })
        : await this.#bridge.call(`/simulation/${service}`, { steps, speed });
    if (action === 'restart') this.#session += 1;
    await this.#ask();
    return answer;
  }

  setParameters(changes) {
    return this.#bridge.call('/simulation/set_parameters', { values_json: JSON.stringify(changes) });
  }

  resetParameters(name) {
    return this.#bridge.call('/simulation/reset_parameters', { names: name === null ? [] : [name] });
  }

  moveArm() {
    return this.setView();
  }

  setView() {
    return Promise.resolve({ success: false, message: WORDS.noStation });
  }

  async #ask() {
    try {
      const { speed, factor, lateness_s, paused, error } = await this.#bridge.call('/simulation/pace');
      this.#update({
        phase: 'running',
        session: this.#session,
        scenario: '',
        error,
        time: this.#time_s,
        paused,
        speed,
        factor,
        lateness: lateness_s,
        pilot: 'me',
        member_ids: ['me'],
        member_names: [WORDS.you],
        asking: [],
        recording: '',
      });
    } catch {
      /* the banner shows that there is no connection */
    }
  }
}
