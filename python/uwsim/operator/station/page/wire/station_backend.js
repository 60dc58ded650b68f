// A station answers as specified in docs/connections/station-wire.md.
import * as messages from './messages.js';

export class StationBackend {
  isPlain = false;
  #bridge;

  constructor(bridge, update) {
    this.#bridge = bridge;
    bridge.subscribe('/station/state', messages.TYPES.StationState, update);
  }

  join(name) {
    return messages.join(this.#bridge, { name });
  }

  describe() {
    return messages.describe(this.#bridge);
  }

  drive(vehicle, efforts, stamp_ms) {
    return messages.drive(this.#bridge, { vehicle, ...efforts, stamp_ms });
  }

  moveArm(request) {
    return messages.moveArm(this.#bridge, request);
  }

  command(name, vehicle, args) {
    return messages.command(this.#bridge, { name, vehicle, args });
  }

  allStop(vehicle, on) {
    return messages.allStop(this.#bridge, { vehicle, on });
  }

  control(action, args) {
    return messages.control(this.#bridge, { action, ...args });
  }

  setParameters(changes) {
    return this.command('set_parameters', '', { changes });
  }

  resetParameters(name) {
    return this.command('reset_parameters', '', { name });
  }

  setView(options) {
    return messages.setView(this.#bridge, options);
  }
}
