// The vehicle's holds: buttons, keys, and their texts on the head-up display.
import { attempt } from '../dom.js';
import { inUnit, unitName } from '../units.js';
import { html } from '../vendor/preact.js';
import { HOLDS as ARGUMENTS } from '../wire/messages.js';

const length = (length_m) => `${inUnit(length_m).toFixed(1)} ${unitName()}`;

// Each hold's title, short name, the hold that it replaces, and a function for the text of its target.
export const HOLDS = {
  heading: { title: 'heading', short: 'HDG', text: (yaw_rad) => `${degrees(yaw_rad)}°` },
  depth: { title: 'depth', short: 'DEP', instead: 'altitude', text: length },
  altitude: { title: 'altitude', short: 'ALT', instead: 'depth', text: length },
  position: { title: 'position', short: 'POS', instead: 'speed', text: (off_m) => `${length(off_m)} off` },
  speed: { title: 'speed', short: 'SPD', instead: 'position', text: (speed_m_s) => `${speed_m_s.toFixed(2)} m/s` },
};

// The compass heading of a yaw, which is counter-clockwise from east: '045'.
const degrees = (yaw_rad) => {
  const heading = Math.round(90 - (yaw_rad * 180) / Math.PI);
  return String(((heading % 360) + 360) % 360).padStart(3, '0');
};

// The arguments of the command that toggles one hold, given the `active` ones.
export function switched(active, name) {
  const on = new Set(active);
  if (!on.delete(name)) {
    on.delete(HOLDS[name].instead);
    on.add(name);
  }
  return Object.fromEntries(ARGUMENTS.map((each) => [each, on.has(each)]));
}

// The displayed text of each active hold: its short name and its target, which is null while the pilot steers or the
// vehicle brakes.
export function shownHolds({ holds = [], hold_targets: targets = [] } = {}) {
  return holds.map((name, k) => ({
    name,
    short: HOLDS[name]?.short ?? name,
    target: Number.isFinite(targets[k]) ? targets[k] : null,
    text: Number.isFinite(targets[k]) ? (HOLDS[name]?.text(targets[k]) ?? '') : '–',
  }));
}

export class HoldButtons {
  #vehicle = { name: '', holds: /** @type {string[]} */ ([]) };
  /** @type {string[] | null} */
  #requested = null; // names, from a press until the telemetry shows them, so that two quick presses add up
  #requestedMs = -Infinity;

  constructor(station, telemetry, pilot, keyOf) {
    this.station = station;
    this.telemetry = telemetry;
    this.pilot = pilot;
    this.keyOf = keyOf;
    telemetry.addEventListener('change', () => this.#repeat());
    station.addEventListener('state', () => this.#repeat());
  }

  begin(vehicle) {
    [this.#vehicle, this.#requested] = [vehicle, null];
  }

  async press(name) {
    if (!this.#vehicle.holds.includes(name)) return;
    const wanted = switched(this.#active, name);
    this.#requested = Object.keys(wanted).filter((each) => wanted[each]);
    this.#requestedMs = performance.now();
    this.pilot.repeat(wanted.speed);
    if (!(await attempt(this.station.command('hold', this.#vehicle.name, wanted)))) this.#requested = null;
  }

  get #active() {
    return this.#requested ?? this.telemetry.message?.holds ?? [];
  }

  #repeat() {
    if (performance.now() - this.#requestedMs > 1000) this.#requested = null;
    this.pilot.repeat(this.#active.includes('speed'));
  }

  view(caption) {
    const { isPilot, connected } = this.station;
    const { holds } = this.#vehicle;
    const button = ([name, { title, short }]) => {
      const key = this.keyOf(`hold.${name}`);
      return html`
        <button type="button" id="hold-${name}" aria-label="${short}: hold ${title}" hidden=${!holds.includes(name)}
          aria-pressed=${this.telemetry.message?.holds?.includes(name) ?? false} disabled=${!isPilot || !connected}
          title="Hold ${title}${key ? ` (${key})` : ''}" onClick=${() => this.press(name)}>${short}</button>
      `;
    };
    return html`
      <div id="holds" class="group" role="group" aria-label="Holds" hidden=${!holds.length}>
        ${caption}${Object.entries(HOLDS).map(button)}
      </div>
    `;
  }
}
