// The newest telemetry of the displayed vehicle, and its age.
import { capital } from './dom.js';
import { TYPES } from './wire/messages.js';
import { seconds } from './wire/rosbridge.js';
import { Closing, soonest } from './views/closing.js';

const LATE_MS = 1500;
const LATE_SIM_S = 2; // at a factor of up to 1: of telemetry behind the time, of a range behind telemetry

export const OFTEN = { throttle_rate: 150 };

// Subscribe to a topic, if there is one. Return what ends that.
export const subscribed = (bridge, topic, type, take, options = undefined) =>
  topic ? [bridge.subscribe(topic, type, take, options)] : [];

// Events: 'change', with each message, and 'age', now and then.
export class Telemetry extends EventTarget {
  #ends = [];
  #closings = new Map(); // by the name of what is approached
  #ranges = new Map(); // of each proximity sensor: { range_m, reach_m, at_s }
  /** @type {import('./wire/messages.js').Telemetry | null} */
  message = null;
  vehicle = ''; // the vehicle's name
  joints = new Map(); // the angles [rad] or ways [m] of the vehicle's motors, by name
  torques = new Map(); // their torques [N m] or forces [N]
  #receivedMs = -Infinity;
  /** @type {import('./wire/messages.js').SensorGauges | null} */
  #readings = null; // the last of the sensors
  sensors = []; // the gauges of sensors that packages add, like those of GAUGES

  constructor(station) {
    super();
    this.station = station;
  }

  // joints: the topic of the motors' angles. proximities: { name, topic } of each proximity sensor. Either may be
  // missing, for example over a modem.
  watch({ name: vehicle, telemetry, sensor_gauges: gauges = null, joints = null, proximities = [] }) {
    for (const end of this.#ends) end();
    [this.message, this.vehicle] = [null, vehicle];
    [this.sensors, this.#readings] = [[], null];
    [this.joints, this.torques] = [new Map(), new Map()];
    this.#closings = new Map();
    this.#ranges = new Map();
    this.#receivedMs = -Infinity;
    const listen = (topic, type, take, options) => subscribed(this.station.bridge, topic, type, take, options);
    const take = ({ name, position, effort = [] }) => {
      this.joints = new Map(name.map((each, k) => [each, position[k]]));
      this.torques = new Map(name.map((each, k) => [each, effort[k] ?? 0]));
    };
    const range = (name) => (message) => {
      const { header, range: near_m, max_range: reach_m } = message;
      const range_m = near_m < reach_m ? near_m : NaN;
      this.#ranges.set(name, { range_m, reach_m, at_s: seconds(header.stamp) });
      this.#approach(name, range_m, header);
    };
    this.#ends = [
      ...listen(telemetry, TYPES.Telemetry, (message) => this.#receive(message), OFTEN),
      ...listen(joints, 'sensor_msgs/JointState', take, { throttle_rate: 100 }),
      ...listen(gauges, TYPES.SensorGauges, (readings) => void (this.#readings = readings), OFTEN),
      ...proximities.flatMap((each) => listen(each.topic, 'sensor_msgs/Range', range(each.name), OFTEN)),
    ];
  }

  // The next contact: { name, time_s }, or null if none is imminent.
  get contact() {
    const silent = new Set([...this.#ranges.keys()].filter((name) => !this.#hasRecent(name)));
    return soonest(new Map([...this.#closings].filter(([name]) => !silent.has(name))));
  }

  // The nearest recent echo around the vehicle [m], the bed's aside, and the range of the sensor to port [m]; NaN if
  // there is none.
  get nearest_m() {
    const { distance_to_port: port = NaN } = this.message ?? {};
    const recent = [...this.#ranges].filter(([name]) => this.#hasRecent(name));
    const found = [port < this.portReach_m ? port : NaN, ...recent.map(([, { range_m }]) => range_m)].filter(
      Number.isFinite,
    );
    return found.length ? Math.min(...found) : NaN;
  }

  // The reaches of ranges in the telemetry, by field.
  get reaches() {
    return { distance_to_port: this.portReach_m };
  }

  get portReach_m() {
    return (this.#ranges.get('port') ?? [...this.#ranges.values()][0])?.reach_m ?? NaN;
  }

  // The telemetry, with the readings of sensors as if they were fields of it.
  #receive(message) {
    const { names = [], units = [], values = [], ages = [] } = this.#readings ?? {};
    const since_s = this.#readings
      ? Math.max(0, seconds(message.header.stamp) - seconds(this.#readings.header.stamp))
      : 0;
    if (names.join() !== this.sensors.map(({ name }) => name).join())
      this.sensors = names.map((name, k) => {
        const word = capital(name.slice('sensor '.length).replaceAll('_', ' '));
        return { name, word, unit: units[k] };
      });
    this.message = Object.assign(message, Object.fromEntries(names.map((name, k) => [name, values[k]])), {
      gauges: [...(message.gauges ?? []), ...names],
      gauge_ages: [...(message.gauge_ages ?? []), ...[...ages].map((age) => age + since_s)],
    });
    this.#receivedMs = performance.now();
    this.#approach('bed', message.distance_to_seabed, message.header);
    this.dispatchEvent(new Event('change'));
  }

  #approach(name, range_m, header) {
    if (!this.#closings.has(name)) this.#closings.set(name, new Closing());
    this.#closings.get(name).add(range_m, seconds(header.stamp));
  }

  get stamp_s() {
    return this.message ? seconds(this.message.header.stamp) : NaN;
  }

  // The lag of the values behind the simulator, in simulated time [s].
  get lag_s() {
    return Math.max(0, this.station.state.time - this.stamp_s);
  }

  // True if a proximity sensor has measured lately; a failed one must not keep a warning.
  #hasRecent(name) {
    return Math.abs(this.stamp_s - this.#ranges.get(name).at_s) <= this.#late_s;
  }

  get #late_s() {
    return LATE_SIM_S * Math.max(1, this.station.state.factor || 1);
  }

  // Whether the values are late.
  get isStale() {
    const { state, isBlind } = this.station;
    if (!this.message || isBlind) return true;
    if (state.paused) return false;
    const slow = state.factor > 0 && state.factor < 1 ? 1 / state.factor : 1;
    return performance.now() - this.#receivedMs > LATE_MS * Math.min(slow, 20) || this.lag_s > this.#late_s;
  }
}
