// The station as seen by the page: the state, this page's identity, and its requests.
import * as messages from './messages.js';
import { accepted, Rosbridge } from './rosbridge.js';

// The address of the rosbridge of this page's own server.
export function bridgeUrl(location) {
  const token = new URLSearchParams(location.search).get('token');
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  return `${scheme}://${location.host}/${token ? `?token=${encodeURIComponent(token)}` : ''}`;
}

const SILENT_MS = 1500; // the state comes twice a second
const DEAD_MS = 10000; // silence after which the page reconnects
const WATCH_MS = 250;

// Events: 'open', 'close', 'state', 'session' (another simulator, or a restart of the same), 'description' (its
// parameters have changed), 'trouble' (detail: a sentence).
export class Station extends EventTarget {
  awaitsBegin = false; // an exercise, by its pilot
  /** @type {any} */
  state = { phase: '', session: -1, pilot: '', member_ids: [], member_names: [], asking: [], driver: '', lost_by: '' };
  /** @type {import('./messages.js').Description | null} */
  description = null;
  id = '';
  flew = false; // whether this page had the controls in the last known state
  isSilent = false; // whether nothing arrives, although the connection seems open
  #isAsking = false;
  #formerId = '';
  #watchedMs = performance.now();

  constructor(url, name) {
    super();
    this.name = name;
    this.bridge = new Rosbridge(url);
    this.bridge.subscribe('/station/state', messages.TYPES.StationState, (state) => this.#update(state));
    this.bridge.addEventListener('open', () => this.#joined());
    this.bridge.addEventListener('close', () => {
      this.id = '';
      this.dispatchEvent(new Event('close'));
    });
    this.bridge.addEventListener('refused', (event) => this.#report(/** @type {CustomEvent} */ (event).detail));
    setInterval(() => this.#watch(), WATCH_MS);
  }

  get connected() {
    return this.bridge.connected;
  }

  get isPilot() {
    return this.connected && !this.isSilent && this.id !== '' && this.state.pilot === this.id;
  }

  get isRunning() {
    return this.state.phase === 'running';
  }

  // Seconds since the last message from the pilot if the pilot is another page whose connection seems dead, else 0.
  get pilotSilence() {
    return this.isPilot || this.state.pilot === '' ? 0 : (this.state.pilot_silence ?? 0);
  }

  // Seconds since the last message.
  get silence_s() {
    return (performance.now() - this.bridge.receivedMs) / 1000;
  }

  // True if nothing arrives, so that everything on this page is out of date.
  get isBlind() {
    return !this.connected || this.isSilent;
  }

  // True if this page lost the controls with its connection, and may take them back.
  get mayTakeBack() {
    const { state } = this;
    const isFree = state.pilot === '' || (state.pilot === this.#formerId && this.pilotSilence > messages.FREE_S);
    return this.flew && !this.isBlind && this.id !== '' && !this.isPilot && isFree;
  }

  // True if the pilot may use a control, such as 'pause'. In an exercise, only a few are permitted.
  may(action) {
    return this.description?.controls?.includes(action) ?? true;
  }

  // The displayed name of a member.
  nameOf(id) {
    const k = this.state.member_ids.indexOf(id);
    return k < 0 ? id : this.state.member_names[k] || id;
  }

  // Change the name shown to the other members.
  async rename(name) {
    const { id } = await accepted(messages.join(this.bridge, { name }));
    [this.name, this.id] = [name, id];
  }

  catalog() {
    return messages.catalog(this.bridge);
  }

  check(choice) {
    return messages.check(this.bridge, choice);
  }

  start(choice) {
    return messages.start(this.bridge, choice);
  }

  takeControl() {
    return messages.takeControl(this.bridge);
  }

  handOver(to) {
    this.flew = to === this.id;
    return messages.handOver(this.bridge, { to });
  }

  // stamp_ms: performance.now() when the controls were read.
  drive(vehicle, efforts, stamp_ms) {
    return messages.drive(this.bridge, { vehicle, ...efforts, stamp_ms });
  }

  moveArm(request) {
    return messages.moveArm(this.bridge, request);
  }

  command(name, vehicle, args = {}) {
    return messages.command(this.bridge, { name, vehicle, args });
  }

  // Set all stop, which any page may do, or release it, which only the pilot may do.
  allStop(vehicle, on) {
    return messages.allStop(this.bridge, { vehicle, on });
  }

  control(action, args = {}) {
    return messages.control(this.bridge, { action, ...args });
  }

  // The names of all current parameters.
  async parameterNames() {
    return (await this.bridge.call('/simulation/list_parameters')).names;
  }

  // The parameters' descriptions: name, type, unit, low, high, choices, value, default and so on.
  async describeParameters(names) {
    return JSON.parse((await this.bridge.call('/simulation/describe_parameters', { names })).descriptions_json);
  }

  // The parameters' values by name.
  async parameterValues(names) {
    return JSON.parse((await this.bridge.call('/simulation/get_parameters', { names })).values_json);
  }

  // Change parameters by name, all or none.
  setParameters(changes) {
    return this.command('set_parameters', '', { changes });
  }

  // Restore the scenario's values at and below a name; null restores all.
  resetParameters(name) {
    return this.command('reset_parameters', '', { name });
  }

  setView(options) {
    return messages.setView(this.bridge, options);
  }

  // A path on the server of this page's simulator, such as '/map/rov.bt'.
  href(path) {
    const socket = new URL(this.bridge.url);
    const token = socket.searchParams.get('token');
    const base = `${socket.protocol === 'wss:' ? 'https' : 'http'}://${socket.host}`;
    return `${base}${path}${token ? `?token=${encodeURIComponent(token)}` : ''}`;
  }

  // Fetch a path from the server of this page's simulator.
  async load(path) {
    const answer = await fetch(this.href(path));
    if (!answer.ok) throw new Error(`${path}: ${answer.status} ${answer.statusText}`);
    return answer;
  }

  async #joined() {
    this.dispatchEvent(new Event('open'));
    try {
      this.id = (await accepted(messages.join(this.bridge, { name: this.name }))).id;
    } catch (error) {
      this.#report(error.message);
      return;
    }
    this.dispatchEvent(new Event('state'));
  }

  // Detect that nothing arrives. A page that was itself suspended cannot tell, so it waits again.
  #watch() {
    const now = performance.now();
    if (now - this.#watchedMs > 3 * WATCH_MS) this.bridge.receivedMs = now;
    this.#watchedMs = now;
    const was = this.isSilent;
    this.isSilent = this.connected && now - this.bridge.receivedMs > SILENT_MS;
    if (this.isSilent && now - this.bridge.receivedMs > DEAD_MS) this.bridge.drop();
    else if (this.isSilent || was) this.dispatchEvent(new Event('state'));
  }

  #report(sentence) {
    this.dispatchEvent(new CustomEvent('trouble', { detail: sentence }));
  }

  async #update(state) {
    this.state = state;
    if (this.id !== '' && state.pilot === this.id) [this.flew, this.#formerId] = [true, this.id];
    else if (state.pilot !== '' && state.pilot !== this.#formerId) this.flew = false;
    if (state.phase === 'running' && !isOf(state, this.description)) await this.#describe();
    if (state.phase !== 'running') this.description = null;
    this.dispatchEvent(new Event('state'));
  }

  async #describe() {
    if (this.#isAsking) return;
    this.#isAsking = true;
    try {
      const description = await messages.describe(this.bridge);
      if (description.success) {
        const isSame = this.description?.session === description.session;
        this.description = /** @type {import('./messages.js').Description} */ (description);
        this.dispatchEvent(new Event(isSame ? 'description' : 'session'));
      }
    } catch (error) {
      this.#report(error.message);
    } finally {
      this.#isAsking = false;
    }
  }
}

// Whether a description matches the simulator and the parameters of a state. Some servers have no editions.
function isOf({ session, edition }, description) {
  return description?.session === session && description.edition === edition;
}
