// The top bar: vehicle, lights, tilt, gain, camera, time.
import { all, attempt, byId, capital, clockText, el, fixed, targetOf, write } from './dom.js';

const TILT_STEP_RAD = Math.PI / 180;
const TILT_HOLD_MS = 100;
const QUALITIES = {
  // of the large picture
  economy: { title: 'Economy', rate_hz: 5, width: 320, quality: 60 },
  normal: { title: 'Normal', rate_hz: 10, width: 640, quality: 80 },
  fine: { title: 'Fine', rate_hz: 10, width: 960, quality: 90 },
};
const LATE_SHARE = 0.95;

export class TopBar {
  /** @type {import('./wire/messages.js').VehicleDescription | null} */
  #vehicle = null;
  #lights = [];
  #tiltTimer = 0;
  #wantedTilt = NaN;

  constructor(station, telemetry, pilot, views) {
    this.station = station;
    this.telemetry = telemetry;
    this.pilot = pilot;
    this.views = views;
    byId('dock').addEventListener('click', () => this.releaseOrDock());
    byId('undock').addEventListener('click', () => this.undock());
    for (const [id, sign] of Object.entries({ 'tilt-up': 1, 'tilt-down': -1 })) {
      byId(id).addEventListener('pointerdown', () => this.tilt(sign, true));
      byId(id).addEventListener('pointerup', () => this.tilt(sign, false));
      byId(id).addEventListener('pointerleave', () => this.tilt(sign, false));
      byId(id).addEventListener('click', (event) => {
        if (event.detail === 0) this.#step(sign);
      }); // by keyboard
    }
    byId('gain-up').addEventListener('click', () => pilot.changeGain(1));
    byId('gain-down').addEventListener('click', () => pilot.changeGain(-1));
    pilot.addEventListener('gain', () => this.#showGain());
    this.#showGain();
    byId('pause').addEventListener('click', () => this.pauseOrResume());
    byId('step').addEventListener('click', () => this.step());
    byId('speed').addEventListener('change', (event) => {
      attempt(station.control('speed', { speed: Number(targetOf(event).value) }));
      targetOf(event).blur();
    });
    this.#makeCameraModes();
    station.addEventListener('state', () => this.showState());
    telemetry.addEventListener('change', () => this.#showVehicle());
    // Space is a driving key, so it must not press the last clicked button again.
    byId('station').addEventListener('pointerup', (event) => {
      /** @type {HTMLElement | null} */ (targetOf(event).closest('button, a'))?.blur();
    });
  }

  begin(vehicle, description, speeds) {
    this.#vehicle = vehicle;
    const names = description.vehicles.map(({ name }) => name);
    byId('vehicle').hidden = names.length < 2;
    byId('vehicle').replaceChildren(
      ...names.map((name) => el('option', { value: name, selected: name === vehicle.name }, name)),
    );
    write(byId('scenario-name'), description.scenario);
    this.#lights = vehicle.lamps.map((name, k) => {
      const title = capital(name);
      return el(
        'button',
        {
          type: 'button',
          'aria-pressed': 'false',
          'aria-label': `${title.toLowerCase()} light`,
          onclick: () => this.light(name, !this.#isLit(k)),
        },
        title,
      );
    });
    byId('lights').replaceChildren(
      el('span', { className: 'caption', 'aria-hidden': 'true' }, 'Lights'),
      ...this.#lights,
    );
    byId('lights').hidden = this.#lights.length === 0;
    byId('droppers').replaceChildren(
      el('span', { className: 'caption', 'aria-hidden': 'true' }, 'Let go'),
      ...vehicle.droppers.map((name) => {
        const title = capital(name.replaceAll('_', ' '));
        return el(
          'button',
          { type: 'button', 'aria-label': `Let go: ${title}`, onclick: () => this.drop(name) },
          title,
        );
      }),
    );
    byId('droppers').hidden = vehicle.droppers.length === 0;
    /** @type {HTMLElement} */ (byId('tilt').parentElement).hidden = !vehicle.tilt;
    byId('speed').replaceChildren(
      ...speeds.map((speed) => el('option', { value: String(speed) }, speed === 0 ? 'max' : `${speed}×`)),
    );
    this.showState();
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

  showState() {
    const { state, isPilot, connected } = this.station;
    write(byId('clock'), clockText(state.time, 1));
    byId('rosbridge').hidden = !state.rosbridge;
    write(byId('rosbridge'), state.rosbridge ? `ROS ${state.rosbridge.replace(/^wss?:\/\//, '')}` : '');
    byId('rosbridge').title = state.rosbridge_refusals ?? '';
    byId('rosbridge').classList.toggle('is-lost', Boolean(state.rosbridge_trouble || state.rosbridge_refusals));
    const speed = byId('speed');
    if (document.activeElement !== speed) {
      const wanted = String(+(+state.speed).toFixed(6));
      if (![...all(speed, 'option')].some(({ value }) => value === wanted))
        speed.append(el('option', { value: wanted }, `${wanted}×`));
      speed.value = wanted;
    }
    const isLate = !state.paused && state.speed > 0 && state.factor < LATE_SHARE * state.speed;
    write(byId('factor'), state.paused ? 'paused' : `${fixed(state.factor, state.factor < 10 ? 2 : 0)}×`);
    byId('factor').classList.toggle('is-late', isLate);
    byId('pause').setAttribute('aria-label', state.paused ? 'Resume' : 'Pause');
    write(byId('pause'), state.paused ? '▶' : '❚❚');
    const mayNot = !isPilot || !connected;
    for (const id of ['dock', 'tilt-up', 'tilt-down', 'gain-up', 'gain-down']) byId(id).disabled = mayNot;
    for (const id of ['speed', 'pause', 'step']) byId(id).hidden = !this.station.may(id);
    for (const button of [byId('speed'), byId('pause'), ...this.#lights]) button.disabled = mayNot;
    byId('step').disabled = mayNot || !state.paused;
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

  #isLit(k) {
    return Boolean(this.telemetry.message?.lamps[k]);
  }

  #showVehicle() {
    const { message } = this.telemetry;
    write(byId('dock'), message.released ? 'Dock' : 'Release');
    byId('undock').hidden = message.released;
    this.#lights.forEach((button, k) => button.setAttribute('aria-pressed', String(this.#isLit(k))));
    write(byId('tilt'), Number.isFinite(message.tilt) ? `${fixed((message.tilt * 180) / Math.PI, 0)}°` : '–');
    if (this.telemetry.stamp_s > this.station.state.time) write(byId('clock'), clockText(this.telemetry.stamp_s, 1));
  }

  #showGain() {
    write(byId('gain'), `${Math.round(100 * this.pilot.gain)} %`);
  }

  #makeCameraModes() {
    const select = el(
      'select',
      { id: 'quality', 'aria-label': 'Quality of the large picture' },
      ...Object.entries(QUALITIES).map(([value, { title }]) =>
        el('option', { value, selected: value === 'normal' }, title),
      ),
    );
    select.addEventListener('change', () => {
      const { rate_hz, width, quality } = QUALITIES[select.value];
      this.views.widths.set(this.views.large, width);
      attempt(this.station.setView({ name: this.views.large, rate_hz, width, quality }));
      select.blur();
    });
    this.views.setTools(select);
  }
}
