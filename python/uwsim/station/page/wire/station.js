// The station as the page knows it: what docs/station-wire.md says, as calls and events.
import { Rosbridge } from './rosbridge.js';

// Where the rosbridge is: this page's own server, or the one that the address bar names (?rosbridge=ws://HOST:PORT).
export function bridgeUrl(location) {
  const asked = new URLSearchParams(location.search);
  const other = asked.get('rosbridge');
  if (other) return other;
  const token = asked.get('token');
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  return `${scheme}://${location.host}/${token ? `?token=${encodeURIComponent(token)}` : ''}`;
}

// Events: 'open', 'close', 'state' (station/state has changed), 'session' (another simulator, or the same one anew).
export class Station extends EventTarget {
  state = { phase: '', session: -1, pilot: '', member_ids: [], member_names: [], asking: [] };
  description = null;
  id = '';

  constructor(url, name) {
    super();
    this.name = name;
    this.bridge = new Rosbridge(url);
    this.bridge.addEventListener('open', () => this.#joined());
    this.bridge.addEventListener('close', () => {
      this.id = '';
      this.dispatchEvent(new Event('close'));
    });
    this.bridge.subscribe('/station/state', 'uwsim_msgs/StationState', (state) => this.#learn(state));
  }

  get connected() { return this.bridge.connected; }

  get isPilot() { return this.connected && this.id !== '' && this.state.pilot === this.id; }

  get isRunning() { return this.state.phase === 'running'; }

  // The name of a member, for people.
  nameOf(id) {
    const k = this.state.member_ids.indexOf(id);
    return k < 0 ? id : this.state.member_names[k] || id;
  }

  catalog() { return this.bridge.call('/station/catalog'); }

  check(choice) { return this.bridge.call('/station/check', choice); }

  start(choice) { return this.bridge.call('/station/start', choice); }

  takeControl() { return this.bridge.call('/station/take_control'); }

  handOver(to) { return this.bridge.call('/station/hand_over', { to }); }

  drive(vehicle, efforts, stampMs) {
    return this.bridge.call('/station/drive', { vehicle, ...efforts, stamp_ms: stampMs });
  }

  command(name, vehicle, args = {}) { return this.bridge.call('/station/command', { name, vehicle, args }); }

  control(action, args = {}) { return this.bridge.call('/station/control', { action, ...args }); }

  // A path on the server that this page's simulator runs on, such as '/map/rov.bt'.
  href(path) {
    const socket = new URL(this.bridge.url);
    const token = socket.searchParams.get('token');
    const base = `${socket.protocol === 'wss:' ? 'https' : 'http'}://${socket.host}`;
    return `${base}${path}${token ? `?token=${encodeURIComponent(token)}` : ''}`;
  }

  async #joined() {
    this.dispatchEvent(new Event('open'));
    try {
      this.id = (await this.bridge.call('/station/join', { name: this.name })).id;
      this.dispatchEvent(new Event('state'));
    } catch (error) {
      this.dispatchEvent(new CustomEvent('trouble', { detail: error.message }));
    }
  }

  async #learn(state) {
    this.state = state;
    const isNew = state.phase === 'running' && this.description?.session !== state.session;
    if (isNew) {
      try {
        const description = await this.bridge.call('/station/describe');
        if (description.success === false) return;
        if (this.description?.session === description.session) return; // another state came meanwhile
        this.description = description;
        this.dispatchEvent(new Event('session'));
      } catch (error) {
        this.dispatchEvent(new CustomEvent('trouble', { detail: error.message }));
      }
    }
    this.dispatchEvent(new Event('state'));
  }
}
