// The newest telemetry of the displayed vehicle, and its age.
import { TYPES } from './wire/messages.js';
import { seconds } from './wire/rosbridge.js';

const LATE_MS = 1500;
const LATE_SIM_S = 2; // behind the simulated time, for example over an acoustic link

export class Telemetry extends EventTarget {
  #end = null;
  message = null;
  #heardMs = -Infinity;

  constructor(station) {
    super();
    this.station = station;
  }

  watch(topic) {
    this.#end?.();
    this.message = null;
    this.#heardMs = -Infinity;
    this.#end = this.station.bridge.subscribe(
      topic,
      TYPES.Telemetry,
      (message) => {
        this.message = message;
        this.#heardMs = performance.now();
        this.dispatchEvent(new Event('change'));
      },
      { throttle_rate: 150 },
    );
  }

  get stamp_s() {
    return this.message ? seconds(this.message.header.stamp) : NaN;
  }

  // Simulated time by which the values are behind the simulator [s].
  get lag_s() {
    return Math.max(0, this.station.state.time - this.stamp_s);
  }

  // Whether the values are older than they should be.
  get isStale() {
    const { state, isBlind } = this.station;
    if (!this.message || isBlind) return true;
    if (state.paused) return false;
    const slow = state.factor > 0 && state.factor < 1 ? 1 / state.factor : 1;
    return (
      performance.now() - this.#heardMs > LATE_MS * Math.min(slow, 20) ||
      this.lag_s > LATE_SIM_S * Math.max(1, state.factor || 1)
    );
  }
}
