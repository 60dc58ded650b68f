// The top bar: all stop, vehicle, lights, tilt, gain, holds, records, the controls, time.
import { attempt, byId, capital, clockText, draw, el, first, fixed, targetOf, watched } from './dom.js';
import { html, signal } from './vendor/preact.js';
import { ALL_STOPPED } from './wire/messages.js';

const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 0];
const TILT_STEP_RAD = Math.PI / 180;
const TILT_HOLD_MS = 100;
const QUALITIES = {
  // of the large picture
  economy: { title: 'Economy', rate_hz: 5, width: 320, quality: 60 },
  normal: { title: 'Normal', rate_hz: 10, width: 640, quality: 80 },
  fine: { title: 'Fine', rate_hz: 10, width: 960, quality: 90 },
};
const LATE_SHARE = 0.95;

const group = (label, ...contents) => html`<div class="group" role="group" aria-label=${label}>${contents}</div>`;
const caption = (text) => html`<span class="caption" aria-hidden="true">${text}</span>`;

const button = (id, label, text, act, more = {}) => html`
  <button id=${id} type="button" aria-label=${label} title=${label} onClick=${act} ...${more}>${text}</button>
`;
const chosen = (act) => (event) => {
  act(event.target.value);
  event.target.blur();
};

// The lamp that shows whether the flight is being recorded: red if it is not.
function recLamp({ state, description }) {
  const isOff = !state.flight;
  const why = isOff
    ? state.flight_trouble || 'This flight is not recorded'
    : `This flight is recorded as ${state.flight}`;
  return html`
    <span id="rec" class="rec ${isOff ? 'is-off' : ''}" role="status" title=${why} hidden=${!description?.is_recorded}>
      ${isOff ? 'NO REC' : 'REC'}
    </span>
  `;
}

export class TopBar {
  /** @type {{ value: import('./wire/messages.js').VehicleDescription | null }} */
  #flown = signal(null);
  #seen; // the bar is drawn again if this changes
  #clock;
  #tiltTimer = 0;
  #wantedTilt = NaN;

  // parts: { holds, recorder, lease }, which have buttons in the bar. acts: what its other buttons do.
  constructor(station, telemetry, pilot, views, parts, acts) {
    this.station = station;
    this.telemetry = telemetry;
    this.pilot = pilot;
    this.views = views;
    this.parts = parts;
    this.acts = acts;
    const root = first(byId('station'), '.topbar');
    const read = (of) => watched(of, [telemetry, 'change'], [station, 'state']);
    this.#seen = read(() => {
      const { released, lamps, holds } = telemetry.message ?? {};
      return JSON.stringify([this.#isStopped, this.#tiltText, released, lamps, holds]);
    });
    this.#clock = read(() => clockText(Math.max(station.state.time ?? 0, telemetry.stamp_s || 0), 1));
    draw(root, () => this.#seen.value && this.#view(), [station, 'state', 'close', 'description'], [pilot, 'gain']);
    this.#makeCameraModes();
    // Space is a driving key, so it must not press the last clicked button again.
    byId('station').addEventListener('pointerup', (event) => {
      /** @type {HTMLElement | null} */ (targetOf(event).closest('button, a'))?.blur();
    });
  }

  get #vehicle() {
    return this.#flown.value;
  }

  begin(vehicle) {
    this.#flown.value = vehicle;
  }

  releaseOrDock() {
    const isFree = this.telemetry.message?.released;
    attempt(this.station.command(isFree ? 'dock' : 'release', this.#vehicle?.name), isFree ? 'Docked' : 'Released');
  }

  undock() {
    attempt(this.station.command('undock', this.#vehicle?.name), 'Undocked');
  }

  // A dropper lets go of its next body; without a name, the first one that holds any.
  drop(name = undefined) {
    attempt(this.station.command('drop', this.#vehicle?.name, name ? { dropper: name } : {}), 'Let go');
  }

  light(name, on) {
    if (this.#vehicle?.lamps.includes(name))
      attempt(this.station.command('set_lamp', this.#vehicle?.name, { lamp: name, on }));
  }

  switchLight(name) {
    const k = this.#vehicle?.lamps.indexOf(name) ?? -1;
    if (k >= 0) this.light(name, !this.#isLit(k));
  }

  // Turn the head while the button is held, at the server's rate.
  tilt(sign, isHeld) {
    clearInterval(this.#tiltTimer);
    this.#tiltTimer = 0;
    if (!this.#vehicle?.tilt) return;
    const { rate_rad_s: rate } = this.#vehicle.tilt;
    if (!isHeld) {
      if (Number.isFinite(this.#wantedTilt)) this.#aim(this.telemetry.message.tilt, true);
      this.#wantedTilt = NaN;
      return;
    }
    this.#wantedTilt = this.telemetry.message?.tilt ?? 0;
    const lead = Math.max(TILT_STEP_RAD, 0.5 * rate);
    const aim = () => this.#aim((this.telemetry.message?.tilt ?? 0) + sign * lead);
    aim();
    this.#tiltTimer = setInterval(aim, TILT_HOLD_MS * 2);
  }

  pauseOrResume() {
    attempt(this.station.control(this.station.state.paused ? 'resume' : 'pause'));
  }

  step() {
    if (this.station.state.paused) attempt(this.station.control('step', { steps: 1 }));
  }

  #step(sign) {
    this.#aim((this.telemetry.message?.tilt ?? 0) + sign * 5 * TILT_STEP_RAD);
  }

  #aim(wanted_rad, isLast = false) {
    if (!this.#vehicle?.tilt) return;
    const { min_rad, max_rad } = this.#vehicle.tilt;
    const elevation_rad = Math.max(min_rad, Math.min(max_rad, wanted_rad));
    if (!isLast || Number.isFinite(elevation_rad))
      attempt(this.station.command('aim', this.#vehicle?.name, { elevation_rad }));
  }

  get #tiltText() {
    const { tilt = NaN } = this.telemetry.message ?? {};
    return Number.isFinite(tilt) ? `${fixed((tilt * 180) / Math.PI, 0)}°` : '–';
  }

  get #isStopped() {
    return this.telemetry.message?.alarms?.includes(ALL_STOPPED) ?? false;
  }

  #isLit(k) {
    return Boolean(this.telemetry.message?.lamps[k]);
  }

  #view() {
    const { station, telemetry, pilot, parts, acts } = this;
    const { state, isPilot, connected, description } = station;
    const { message } = telemetry;
    const vehicle = this.#vehicle;
    const { lamps = [], droppers = [], tilt = null } = vehicle ?? {};
    const names = (description?.vehicles ?? []).map(({ name }) => name);
    const mayNot = !isPilot || !connected;
    const isFree = Boolean(message?.released);
    const turn = (id, label, text, sign) => html`
      <button id=${id} type="button" aria-label=${label} disabled=${mayNot}
        onPointerDown=${() => this.tilt(sign, true)} onPointerUp=${() => this.tilt(sign, false)}
        onPointerLeave=${() => this.tilt(sign, false)}
        onClick=${({ detail }) => detail === 0 && this.#step(sign) /* by keyboard */}>${text}</button>
    `;
    const light = (name, k) => html`
      <button type="button" aria-pressed=${this.#isLit(k)} aria-label="${name.toLowerCase()} light" disabled=${mayNot}
        onClick=${() => this.light(name, !this.#isLit(k))}>${capital(name)}</button>
    `;
    const dropper = (name) => html`
      <button type="button" aria-label="Let go: ${capital(name.replaceAll('_', ' '))}" onClick=${() => this.drop(name)}>
        ${capital(name.replaceAll('_', ' '))}
      </button>
    `;
    const speeds = [...new Set([...SPEEDS, +(+(state.speed ?? 1)).toFixed(6)])];
    const isLate = !state.paused && state.speed > 0 && state.factor < LATE_SHARE * state.speed;
    const factor = state.paused ? 'paused' : `${fixed(state.factor, state.factor < 10 ? 2 : 0)}×`;
    return html`
      <button id="all-stop" type="button" class="danger" aria-pressed=${this.#isStopped}
        title="All stop (X)" onClick=${acts.stop}>All stop</button>
      <button id="unfold" type="button" aria-label="All controls" aria-expanded="false"
        onClick=${acts.unfold}>⋯</button>
      <h1 class="brand">
        <span class="mark"><img src="icon.svg" alt="" width="22" height="22" /></span>
        <span id="scenario-name" title=${description?.branched_from && `Flown on from ${description.branched_from}`}>
          ${description?.scenario ?? 'uwsim'}
        </span>
      </h1>
      ${group(
        'Vehicle',
        html`
          <select id="vehicle" aria-label="Vehicle being flown" value=${vehicle?.name} hidden=${names.length < 2}
            onChange=${chosen(acts.fly)}>${names.map((name) => html`<option value=${name}>${name}</option>`)}</select>
          <button id="dock" type="button" class="strong" disabled=${mayNot} onClick=${() => this.releaseOrDock()}>
            ${isFree ? 'Dock' : 'Release'}
          </button>
          <button id="undock" type="button" title="Leave the station for open water (Y)" hidden=${!message || isFree}
            onClick=${() => this.undock()}>Undock</button>
        `,
      )}
      <div id="lights" class="group" role="group" aria-label="Lights" hidden=${!lamps.length}>
        ${caption('Lights')}${lamps.map(light)}
      </div>
      <div id="droppers" class="group" role="group" aria-label="Droppers and launchers" hidden=${!droppers.length}>
        ${caption('Let go')}${droppers.map(dropper)}
      </div>
      <div class="group" role="group" aria-label="Sonar tilt" hidden=${!tilt}>
        ${caption('Tilt')}${turn('tilt-up', 'Sonar nose up', '▲', 1)}
        <output id="tilt" class="reading" aria-label="Sonar tilt">${this.#tiltText}</output>
        ${turn('tilt-down', 'Sonar nose down', '▼', -1)}
      </div>
      ${group(
        'Gain of the controls',
        caption('Gain'),
        html`<button id="gain-down" type="button" aria-label="Less gain" disabled=${mayNot}
          onClick=${() => pilot.changeGain(-1)}>−</button>`,
        html`<output id="gain" class="reading" aria-label="Gain">${Math.round(100 * pilot.gain)} %</output>`,
        html`<button id="gain-up" type="button" aria-label="More gain" disabled=${mayNot}
          onClick=${() => pilot.changeGain(1)}>+</button>`,
      )}
      ${parts.holds.view(caption('Hold'))}
      ${group('Records', parts.recorder.view())}
      <span class="spring" />
      ${recLamp(station)}
      <span id="rosbridge" class="rosbridge ${state.rosbridge_trouble || state.rosbridge_refusals ? 'is-lost' : ''}"
        title=${state.rosbridge_refusals ?? ''} hidden=${!state.rosbridge}>
        ${state.rosbridge ? `ROS ${state.rosbridge.replace(/^wss?:\/\//, '')}` : ''}
      </span>
      ${parts.lease.view()}
      <div class="group time" role="group" aria-label="Time">
        <output id="clock" class="reading clock" aria-label="Simulated time">${this.#clock}</output>
        <select id="speed" aria-label="Requested speed" hidden=${!station.may('speed')} disabled=${mayNot}
          value=${String(+(+(state.speed ?? 1)).toFixed(6))}
          onChange=${chosen((speed) => attempt(station.control('speed', { speed: Number(speed) })))}>
          ${speeds.map((speed) => html`<option value=${speed}>${speed === 0 ? 'max' : `${speed}×`}</option>`)}
        </select>
        <output id="factor" class="reading factor ${isLate ? 'is-late' : ''}" aria-label="Achieved speed">
          ${factor}
        </output>
        <button id="pause" type="button" aria-label=${state.paused ? 'Resume' : 'Pause'} hidden=${!station.may('pause')}
          disabled=${mayNot} onClick=${() => this.pauseOrResume()}>${state.paused ? '▶' : '❚❚'}</button>
        <button id="step" type="button" aria-label="One step" hidden=${!station.may('step')}
          disabled=${mayNot || !state.paused} onClick=${() => this.step()}>❚▶</button>
      </div>
      ${group(
        'Station',
        button('inspect', 'Parameters', '⚙', null, {
          hidden: description?.has_exercise,
          'aria-expanded': 'false', // the inspector changes it
          'aria-controls': 'inspector',
        }),
        button('help', 'Keys', '?', acts.keys, { title: 'Keys (?)' }),
        button('menu', 'Menu', '☰', acts.menu, { title: 'Menu (Esc)' }),
      )}
    `;
  }

  #makeCameraModes() {
    const onchange = chosen((value) => {
      const { rate_hz, width, quality } = QUALITIES[value];
      this.views.widths.set(this.views.large, width);
      attempt(this.station.setView({ name: this.views.large, rate_hz, width, quality }));
    });
    const options = Object.entries(QUALITIES).map(([value, { title }]) =>
      el('option', { value, selected: value === 'normal' }, title),
    );
    this.views.setTools(
      el('select', { id: 'quality', 'aria-label': 'Quality of the large picture', onchange }, ...options),
    );
  }
}
