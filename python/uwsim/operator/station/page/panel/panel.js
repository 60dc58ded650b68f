// The panel: all values of the paper's panel, the position, bars, the link and the map.
import { clockText, el, fixed, grouped, write } from '../dom.js';
import { unitName } from '../units.js';
import { Alarms } from './alarms.js';
import { AllStop } from './all_stop.js';
import { Arm } from './arm.js';
import { Bars } from './bars.js';
import { ExercisePanel } from './exercise.js';
import { Failsafe } from './failsafe.js';
import { Link } from './link.js';
import { AROUND, BIG, LENGTH, MOTION, POSITION, gaugeRow } from './rows.js';
import { TetherPanel } from './tether.js';

const LOW_PERCENT = 25;
const EMPTY_PERCENT = 10;
const OLD_S = 1.5; // age from which a measurement is greyed out, plus the interval of slow instruments
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

export class Panel {
  #values = []; // [element, text of m, tip of m, measured field, element with the name of the unit of lengths]
  #own = 0; // of them: those that are not of sensors that packages add
  #sensors = []; // the gauges of these
  alarms = new Alarms();
  thrusters = new Bars();
  efforts = new Bars();

  // inspection: see Inspection.
  constructor(container, station, telemetry, pilot, inspection) {
    this.station = station;
    this.telemetry = telemetry;
    this.pilot = pilot;
    this.allStop = new AllStop(station, pilot);
    this.failsafe = new Failsafe(station);
    this.link = new Link(station);
    this.tether = new TetherPanel(station);
    this.arm = new Arm(station, telemetry, pilot.arm);
    this.kind = el('small');
    this.age = el('small');
    this.battery = el('i');
    this.meter = el(
      'div',
      { className: 'meter', role: 'meter', 'aria-label': 'Battery', 'aria-valuemin': 0, 'aria-valuemax': 100 },
      this.battery,
    );
    this.mapNote = el('small');
    this.downloads = el('div', { className: 'downloads', role: 'group', 'aria-label': 'Download the map' });
    this.efforts.name(EFFORTS);
    this.charge = el('small');
    this.driveTitle = el('span', {}, 'Thrusters');
    this.around = this.#list(AROUND);
    this.timed = el(
      'div',
      {},
      this.#section('', this.age, this.#list(BIG, 'big-values'), this.#list(MOTION)),
      this.#section('Position', this.kind, this.#list(POSITION, 'big-values small')),
      this.#section('Around', null, this.around),
      this.#section('Battery', this.charge, this.meter),
      this.#section(this.driveTitle, el('small', {}, '%'), this.thrusters.element),
    );
    this.#own = this.#values.length;
    this.exercise = new ExercisePanel(station);
    container.append(
      this.allStop.element,
      this.failsafe.element,
      this.exercise.element,
      this.alarms.element,
      this.timed,
      this.arm.element,
      inspection.element,
      this.tether.element,
      this.link.element,
      this.#section('Controls', el('small', {}, '%'), this.efforts.element),
      this.#section('Map', this.mapNote, this.downloads),
    );
    telemetry.addEventListener('change', () => this.show());
    pilot.addEventListener('efforts', () => this.efforts.show(Object.values(pilot.efforts)));
    setInterval(() => this.show(), 500);
  }

  begin(vehicle, description) {
    this.allStop.begin(vehicle);
    this.failsafe.begin(vehicle);
    this.arm.begin(vehicle);
    this.exercise.begin(description);
    this.link.begin(vehicle, description.views);
    this.tether.begin(vehicle);
    this.hasThrusters = vehicle.thrusters.length > 0; // otherwise it is driven by forces along and about the axes
    this.thrusters.name(this.hasThrusters ? vehicle.thrusters : EFFORTS);
    write(this.driveTitle, this.hasThrusters ? 'Thrusters' : 'Thrust');
    this.downloads.hidden = !vehicle.map;
    this.downloads.replaceChildren(
      ...['bt', 'ply', 'pcd', 'tif'].map((kind) =>
        el(
          'a',
          {
            href: this.station.href(`${vehicle.map}.${kind}`),
            download: '',
            'aria-label': `Download the map as .${kind}`,
          },
          `.${kind}`,
        ),
      ),
    );
  }

  showMap({ count, resolution_m }) {
    write(this.mapNote, count ? `${grouped(count)} voxels of ${+resolution_m.toFixed(3)} m` : 'no pings yet');
  }

  show() {
    const { message, isStale, lag_s, contact, nearest_m, reaches, sensors } = this.telemetry;
    this.timed.classList.toggle('is-stale', isStale);
    this.alarms.setPublished(this.station.description?.warnings?.as_published ?? false);
    this.alarms.show(message, isStale, { time_s: this.telemetry.stamp_s, contact, nearest_m });
    if (this.station.isBlind && this.station.flew) this.alarms.warnOfSilence();
    this.allStop.show(message, isStale);
    this.failsafe.show(message, isStale);
    this.arm.show(isStale);
    write(
      this.age,
      !message ? 'waiting' : this.station.isBlind ? 'not connected' : lag_s > 1 ? `${fixed(lag_s, 1)} s old` : '',
    );
    if (!message) return;
    if (sensors !== this.#sensors) {
      this.#sensors = sensors;
      this.#values.length = this.#own;
      const kept = [...this.around.children].slice(0, AROUND.length);
      this.around.replaceChildren(...kept, ...this.#list(sensors.map(gaugeRow)).children);
    }
    for (const [element, read, explain, field, lengths] of this.#values) {
      if (lengths) write(lengths, unitName());
      write(element, read(message, reaches));
      const age = ageText(ageOf(field, message));
      element.parentElement.classList.toggle('is-stale', age !== '');
      element.title = age || (explain?.(message) ?? '');
    }
    write(this.kind, estimateText(message));
    const isOff = !message.released || message.battery <= 0; // efforts then have no effect
    this.thrusters.show(isOff ? [] : this.hasThrusters ? message.thrusters : message.efforts);
    const percent = Math.max(0, Math.min(100, message.battery));
    this.battery.style.width = `${percent}%`;
    this.meter.dataset.level = percent <= EMPTY_PERCENT ? 'empty' : percent <= LOW_PERCENT ? 'low' : 'good';
    this.meter.setAttribute('aria-valuenow', percent.toFixed(0));
    write(this.charge, `${fixed(message.battery, 0)} % · ${clockText(message.mission_time)} used`);
  }

  #section(title, note, ...contents) {
    const head = title || note ? el('h2', {}, title || 'Vehicle', note) : null;
    return el('section', {}, head, ...contents);
  }

  #list(rows, className = 'values') {
    const list = el('dl', { className });
    for (const [name, unit, read, explain, field] of rows) {
      const value = el('span', {}, '–');
      const suffix = unit ? el('span', { className: 'unit' }, unit) : null;
      this.#values.push([value, read, explain, field, unit === LENGTH ? suffix : null]);
      const parts = [el('dt', {}, name), el('dd', {}, value, suffix)];
      list.append(el('div', {}, ...parts));
    }
    return list;
  }
}
