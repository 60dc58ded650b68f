// The panel: all values of the paper's panel, the position, bars, the link and the map.
import { clockText, draw, fixed, grouped, part } from '../dom.js';
import { unitName } from '../units.js';
import { html, signal } from '../vendor/preact.js';
import { Alarms } from './alarms.js';
import { AllStop } from './all_stop.js';
import { Arm } from './arm.js';
import { ExercisePanel } from './exercise.js';
import { failsafe } from './failsafe.js';
import { Link } from './link.js';
import { AROUND, BIG, downloads, LENGTH, MOTION, POSITION, gaugeRow, valueRow } from './rows.js';
import { TetherPanel } from './tether.js';

const LOW_PERCENT = 25;
const EMPTY_PERCENT = 10;
const OLD_S = 1.5; // age from which a measurement is greyed out, plus the interval of slow instruments
const MAP_KINDS = ['bt', 'ply', 'pcd', 'tif'];
const EFFORTS = ['Surge', 'Sway', 'Heave', 'Roll', 'Pitch', 'Yaw'];

// The age of a measured value [s]; 0 if the telemetry does not report it.
export function ageOf(field, { gauges = [], gauge_ages: ages = [] }) {
  const k = gauges.indexOf(field);
  return k < 0 ? 0 : ages[k];
}

// "measured 3.0 s ago", for an old value.
export function ageText(age_s) {
  if (age_s <= OLD_S) return '';
  return Number.isFinite(age_s) ? `measured ${age_s.toFixed(1)} s ago` : 'no valid measurement';
}

// The accuracy of the estimated position, and its true error if that may be shown.
function estimateText({ position, position_std: std, true_position: truth, is_truth: isTruth }) {
  if (!Number.isFinite(position[0])) return '';
  const off_m = Math.hypot(...position.map((value, k) => value - truth[k]));
  return `± ${fixed(Math.hypot(...std), 2)} m${isTruth ? `, truly ${fixed(off_m, 2)} m off` : ''}`;
}

// Bars from a middle line, for thrusters and efforts: values in [-1, 1], shown in percent.
const bars = (names, values) => {
  const share = (k) => Math.max(-1, Math.min(1, values[k] ?? 0));
  return html`<div class="bars">${names.map((name, k) => html`<${Bar} name=${name} share=${share(k)} />`)}</div>`;
};

const Bar = part(
  ({ name, share }) => html`
    <div title=${name.replaceAll('_', ' ')}>
      <output aria-label=${name}>${Math.round(100 * share)}</output>
      <div class="bar" aria-hidden="true">
        <i style=${{ top: `${50 - 50 * Math.max(share, 0)}%`, height: `${50 * Math.abs(share)}%` }} />
      </div>
      <span aria-hidden="true">${shortened(name)}</span>
    </div>
  `,
);

// A short name that fits below a bar: "vertical_front_left" becomes "v f l", "T3" stays.
function shortened(name) {
  const words = name.split('_');
  return words.length === 1 ? name.slice(0, 6) : words.map((word) => word.slice(0, words.length > 2 ? 1 : 2)).join('');
}

const section = (title, note, ...contents) =>
  html`<section><h2>${title}<small>${note}</small></h2>${contents}</section>`;

export class Panel {
  /** @type {{ value: import('../wire/messages.js').VehicleDescription | null }} */
  #vehicle = signal(null);
  #mapNote = signal('');
  alarms = new Alarms();

  // inspection: see Inspection.
  constructor(container, station, telemetry, pilot, inspection) {
    this.station = station;
    this.telemetry = telemetry;
    this.pilot = pilot;
    this.inspection = inspection;
    this.allStop = new AllStop(station, pilot);
    this.link = new Link(station);
    this.tether = new TetherPanel(station);
    this.arm = new Arm(station, telemetry, pilot.arm);
    this.exercise = new ExercisePanel(station);
    telemetry.addEventListener('change', () => this.#hear());
    setInterval(() => {
      this.#hear();
      telemetry.dispatchEvent(new Event('age'));
    }, 500);
    const seldom = (view, ...more) => part(view, [station, 'state'], ...more);
    const often = (view, ...more) => seldom(() => view(telemetry.isStale), [telemetry, 'change', 'age'], ...more);
    const sections = [
      often((isStale) => this.allStop.view(isStale)),
      often((isStale) => failsafe(station, this.#vehicle.value?.name, telemetry.message, isStale)),
      seldom(() => this.exercise.view()),
      often((isStale) => this.alarms.view(isStale)),
      often((isStale) => this.#gauges(isStale)),
      often((isStale) => this.arm.view(isStale), [pilot.arm, 'part']),
      seldom(() => inspection.view()),
      seldom(() => this.tether.view()),
      seldom(() => this.link.view()),
      seldom(() => this.#controls(), [pilot, 'efforts']),
      seldom(() => this.#map()),
    ];
    draw(container, () => sections.map((each) => html`<${each} />`));
  }

  begin(vehicle, description) {
    this.allStop.begin(vehicle);
    this.arm.begin(vehicle);
    this.exercise.begin(description);
    this.link.begin(vehicle, description.views);
    this.tether.begin(vehicle);
    this.#vehicle.value = vehicle;
  }

  showMap({ count, resolution_m }) {
    this.#mapNote.value = count ? `${grouped(count)} voxels of ${+resolution_m.toFixed(3)} m` : 'no pings yet';
  }

  // Warn of what the telemetry reports.
  #hear() {
    const { message, isStale, contact, nearest_m, stamp_s: time_s } = this.telemetry;
    this.alarms.isAsPublished = this.station.description?.warnings?.as_published ?? false;
    this.alarms.hear(message, isStale, { time_s, contact, nearest_m });
    if (this.station.isBlind && this.station.flew) this.alarms.warnOfSilence();
    this.allStop.hear(message);
  }

  #list(rows, className = 'values') {
    const { message, reaches } = this.telemetry;
    const row = ([name, unit, read, explain, field]) => {
      const age = message ? ageText(ageOf(field, message)) : '';
      const text = message ? read(message, reaches) : '–';
      const title = age || (message && explain?.(message)) || '';
      return valueRow(name, unit === LENGTH ? unitName() : unit, text, title, age !== '');
    };
    return html`<dl class=${className}>${rows.map(row)}</dl>`;
  }

  #battery({ battery = 100 } = {}) {
    const percent = Math.max(0, Math.min(100, battery));
    const level = percent <= EMPTY_PERCENT ? 'empty' : percent <= LOW_PERCENT ? 'low' : 'good';
    return html`
      <div class="meter" role="meter" aria-label="Battery" aria-valuemin="0" aria-valuemax="100"
        aria-valuenow=${percent.toFixed(0)} data-level=${level}>
        <i style=${{ width: `${percent}%` }} />
      </div>
    `;
  }

  #gauges(isStale) {
    const { station, telemetry } = this;
    const { message, lag_s, sensors } = telemetry;
    const { thrusters = [] } = this.#vehicle.value ?? {};
    const hasThrusters = thrusters.length > 0; // otherwise it is driven by forces along and about the axes
    const isOff = !message?.released || message.battery <= 0; // efforts then have no effect
    const age = !message ? 'waiting' : station.isBlind ? 'not connected' : lag_s > 1 ? `${fixed(lag_s, 1)} s old` : '';
    const charge = message ? `${fixed(message.battery, 0)} % · ${clockText(message.mission_time)} used` : '';
    const driven = isOff ? [] : hasThrusters ? message.thrusters : message.efforts;
    return html`
      <div class=${isStale ? 'is-stale' : ''}>
        ${section('Vehicle', age, this.#list(BIG, 'big-values'), this.#list(MOTION))}
        ${section('Position', message ? estimateText(message) : '', this.#list(POSITION, 'big-values small'))}
        ${section('Around', '', this.#list([...AROUND, ...sensors.map(gaugeRow)]))}
        ${section('Battery', charge, this.#battery(message ?? {}))}
        ${section(hasThrusters ? 'Thrusters' : 'Thrust', '%', bars(hasThrusters ? thrusters : EFFORTS, driven))}
      </div>
    `;
  }

  #controls() {
    if (this.station.description?.replay) return '';
    return section('Controls', '%', bars(EFFORTS, Object.values(this.pilot.efforts)));
  }

  #map() {
    const { map = null } = this.#vehicle.value ?? {};
    const file = (kind) => ({
      href: this.station.href(`${map}.${kind}`),
      download: '',
      'aria-label': `Download the map as .${kind}`,
    });
    return section('Map', this.#mapNote.value, downloads('Download the map', map ? MAP_KINDS : [], file));
  }
}
