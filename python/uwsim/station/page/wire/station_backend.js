// A station answers as docs/station-wire.md says.

export class StationBackend {
  isPlain = false;
  #bridge;

  constructor(bridge, learn) {
    this.#bridge = bridge;
    bridge.subscribe('/station/state', 'uwsim_msgs/StationState', learn);
  }

  join(name) {
    return this.#bridge.call('/station/join', { name });
  }

  describe() {
    return this.#bridge.call('/station/describe');
  }

  drive(vehicle, efforts, stamp_ms) {
    return this.#bridge.call('/station/drive', { vehicle, ...efforts, stamp_ms });
  }

  command(name, vehicle, args) {
    return this.#bridge.call('/station/command', { name, vehicle, args });
  }

  allStop(vehicle, on) {
    return this.#bridge.call('/station/all_stop', { vehicle, on });
  }

  control(action, args) {
    return this.#bridge.call('/station/control', { action, ...args });
  }

  setView(options) {
    return this.#bridge.call('/station/set_view', options);
  }
}
