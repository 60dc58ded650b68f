// The panel: all values of the paper's panel, the position, bars, the link and the map.
import { attitude } from '../attitude.js';
import { clockText, el, fixed, grouped, tip, write } from '../dom.js';
import { inUnit, unitName } from '../units.js';
import { Alarms } from './alarms.js';
import { AllStop } from './all_stop.js';
import { Arm } from './arm.js';
import { Bars } from './bars.js';
import { ExercisePanel } from './exercise.js';
import { Failsafe } from './failsafe.js';
import { Link } from './link.js';
import { TetherPanel } from './tether.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.panel;

const LOW_PERCENT = 25;
const EMPTY_PERCENT = 10;
const OLD_S = 1.5; // age from which a measurement is greyed out, plus the interval of slow instruments
// The telemetry field of each value that is measured aboard.
const GAUGES = {
  [WORDS.depth]: 'depth',
  [WORDS.altitude]: 'distance_to_seabed',
  [WORDS.speed]: 'speed',
  [WORDS.turning]: 'angular_speed',
  [WORDS.accel]: 'linear_acceleration',
  [WORDS.angularAccel]: 'angular_acceleration',
  [WORDS.east]: 'position',
  [WORDS.north]: 'position',
  [WORDS.up]: 'position',
  [WORDS.station]: 'distance_to_station',
  [WORDS.portSide]: 'distance_to_port',
  [WORDS.water]: 'temperature',
  [WORDS.pressure]: 'pressure',
};
const EFFORTS = [WORDS.surge, WORDS.sway, WORDS.heave, WORDS.roll, WORDS.pitch, WORDS.yaw];
const LENGTH = 'length'; // in the pilot's unit
const RANGE = (value, digits = 1) => (value === Infinity ? WORDS.none : fixed(value, digits));

// A range, or that nothing is within the sensor's reach.
const beyond = (range_m, reach_m) =>
  range_m >= reach_m ? WORDS.beyond(fixed(inUnit(reach_m), 0)) : RANGE(inUnit(range_m));

const DEG = 180 / Math.PI;
// Format a vector in body axes, such as "1.20 ahead, -0.10 to port, 0.00 up".
const components = (vector, names) => names.map((name, k) => `${fixed(vector[k], 2)} ${name}`).join(', ');

// Each value: name, unit, a function of the telemetry m, and optionally a tooltip.
const BIG = [
  [WORDS.depth, LENGTH, (m) => fixed(inUnit(m.depth), 1)],
  [WORDS.altitude, LENGTH, (m) => RANGE(inUnit(m.distance_to_seabed))],
  [WORDS.heading, '°', (m) => String(Math.round(attitude(m.orientation).heading_deg) % 360).padStart(3, '0')],
];
const MOTION = [
  [WORDS.speed, 'm/s', (m) => fixed(m.speed, 2)],
  [WORDS.turning, '°/s', (m) => fixed(DEG * m.angular_speed, 1)],
  [
    WORDS.accel,
    'm/s²',
    (m) => fixed(Math.hypot(...m.linear_acceleration), 2),
    (m) => components(m.linear_acceleration, [WORDS.ahead, WORDS.toPort, WORDS.upWard]),
  ],
  [
    WORDS.angularAccel,
    '°/s²',
    (m) => fixed(DEG * Math.hypot(...m.angular_acceleration), 1),
    (m) =>
      components(
        [...m.angular_acceleration].map((value) => DEG * value),
        [WORDS.rollRate, WORDS.pitchRate, WORDS.yawRate],
      ),
  ],
  [WORDS.roll, '', (m) => sided(attitude(m.orientation).roll_deg, WORDS.sStarboard, WORDS.sPort)],
  [WORDS.pitch, '°', (m) => fixed(attitude(m.orientation).nose_up_deg, 1)],
];
const POSITION = [
  [WORDS.east, 'm', (m) => fixed(m.position[0], 1)],
  [WORDS.north, 'm', (m) => fixed(m.position[1], 1)],
  [WORDS.up, 'm', (m) => fixed(m.position[2], 1)],
];
const AROUND = [
  [WORDS.station, LENGTH, (m) => fixed(inUnit(m.distance_to_station), 1)],
  [WORDS.portSide, LENGTH, (m, reach_m) => beyond(m.distance_to_port, reach_m)],
  [WORDS.water, '°C', (m) => fixed(m.temperature, 1)],
  [WORDS.pressure, 'kPa', (m) => fixed(m.pressure / 1000, 1)],
  [WORDS.soundDelay, 'ms', (m) => fixed(1000 * m.link_delay, 0)],
  [WORDS.collisions, '', (m) => String(m.collisions)],
];

// The age of a measured value [s]; 0 if the telemetry does not report it.
export function ageOf(field, { gauges = [], gauge_ages: ages = [] }) {
  const k = gauges.indexOf(field);
  return k < 0 ? 0 : ages[k];
}

// "measured 3.0 s ago", for an old value.
export function ageText(age_s) {
  if (age_s <= OLD_S) return '';
  return Number.isFinite(age_s) ? WORDS.old(age_s.toFixed(1)) : WORDS.noValidMeasurement;
}

// The accuracy of the estimated position, and its true error if that may be shown.
function estimateText({ position, position_std: std, true_position: truth, is_truth: isTruth }) {
  if (!Number.isFinite(position[0])) return '';
  const off_m = Math.hypot(...position.map((value, k) => value - truth[k]));
  return `± ${fixed(Math.hypot(...std), 2)} m${isTruth ? WORDS.truly(fixed(off_m, 2)) : ''}`;
}

// Format an angle to a side: "2.0° S" is to starboard.
function sided(value, positive, negative) {
  const text = fixed(Math.abs(value), 1);
  return Number(text) ? `${text}° ${value > 0 ? positive : negative}` : `${text}°`;
}

export class Panel {
  #lengths = []; // elements with the name of the unit of lengths
  #values = []; // [element, text of m, tip of m, measured field]
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
    this.arm = new Arm(station, telemetry);
    this.kind = el('small');
    this.age = el('small');
    this.battery = el('i');
    this.meter = el(
      'div',
      { className: 'meter', role: 'meter', 'aria-label': WORDS.battery, 'aria-valuemin': 0, 'aria-valuemax': 100 },
      this.battery,
    );
    this.mapNote = el('small');
    this.downloads = el('div', { className: 'downloads', role: 'group', 'aria-label': WORDS.downloadTheMap });
    this.efforts.name(EFFORTS);
    this.charge = el('small');
    this.driveTitle = el('span', {}, WORDS.thrusters);
    this.timed = el(
      'div',
      {},
      this.#section('', this.age, this.#list(BIG, 'big-values'), this.#list(MOTION)),
      this.#section(WORDS.position, this.kind, this.#list(POSITION, 'big-values small')),
      this.#section(WORDS.around, null, this.#list(AROUND)),
      this.#section(WORDS.battery, this.charge, this.meter),
      this.#section(this.driveTitle, el('small', {}, '%'), this.thrusters.element),
    );
    this.exercise = new ExercisePanel(station);
    this.instruction = el('p', { className: 'failsafe', id: 'instruction', role: 'status', hidden: true });
    container.append(
      this.instruction,
      this.allStop.element,
      this.failsafe.element,
      this.exercise.element,
      this.alarms.element,
      this.timed,
      this.arm.element,
      inspection.element,
      this.tether.element,
      this.link.element,
      this.#section(WORDS.controls, el('small', {}, '%'), this.efforts.element),
      this.#section(WORDS.map, this.mapNote, this.downloads),
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
    write(this.driveTitle, this.hasThrusters ? WORDS.thrusters : WORDS.thrust);
    this.downloads.hidden = !vehicle.map;
    this.downloads.replaceChildren(
      ...['bt', 'ply', 'pcd', 'tif'].map((kind) =>
        el(
          'a',
          {
            href: this.station.href(`${vehicle.map}.${kind}`),
            download: '',
            'aria-label': WORDS.downloadAs(kind),
          },
          `.${kind}`,
        ),
      ),
    );
  }

  // text: the instructor's last message, or ''.
  showInstruction(text) {
    this.instruction.hidden = text === '';
    write(this.instruction, STRINGS.instructor.from(text));
  }

  showMap({ count, resolution_m }) {
    write(this.mapNote, count ? WORDS.voxels(grouped(count), +resolution_m.toFixed(3)) : WORDS.noPingsYet);
  }

  show() {
    const { message, isStale, lag_s, contact, nearest_m, portReach_m } = this.telemetry;
    this.timed.classList.toggle('is-stale', isStale);
    this.alarms.show(message, isStale, { time_s: this.telemetry.stamp_s, contact, nearest_m });
    if (this.station.isBlind && this.station.flew) this.alarms.warnOfSilence();
    this.allStop.show(message, isStale);
    this.failsafe.show(message, isStale);
    this.arm.show(isStale);
    write(
      this.age,
      !message
        ? WORDS.waiting
        : this.station.isBlind
          ? WORDS.notConnected
          : lag_s > 1
            ? WORDS.late(fixed(lag_s, 1))
            : '',
    );
    if (!message) return;
    for (const element of this.#lengths) write(element, unitName());
    for (const [element, read, explain, field] of this.#values) {
      write(element, read(message, portReach_m));
      const age = ageText(ageOf(field, message));
      element.parentElement.classList.toggle('is-stale', age !== '');
      tip(element, age || (explain?.(message) ?? ''));
    }
    write(this.kind, estimateText(message));
    const isOff = !message.released || message.battery <= 0; // efforts then have no effect
    this.thrusters.show(isOff ? [] : this.hasThrusters ? message.thrusters : message.efforts);
    const percent = Math.max(0, Math.min(100, message.battery));
    this.battery.style.width = `${percent}%`;
    this.meter.dataset.level = percent <= EMPTY_PERCENT ? 'empty' : percent <= LOW_PERCENT ? 'low' : 'good';
    this.meter.setAttribute('aria-valuenow', percent.toFixed(0));
    write(this.charge, WORDS.used(fixed(message.battery, 0), clockText(message.mission_time)));
  }

  #section(title, note, ...contents) {
    const head = title || note ? el('h2', {}, title || WORDS.vehicle, note) : null;
    return el('section', {}, head, ...contents);
  }

  #list(rows, className = 'values') {
    const list = el('dl', { className });
    for (const [name, unit, read, explain] of rows) {
      const value = el('span', {}, '–');
      this.#values.push([value, read, explain, GAUGES[name]]);
      const suffix = unit ? el('span', { className: 'unit' }, unit) : null;
      if (unit === LENGTH) this.#lengths.push(suffix);
      const parts = [el('dt', {}, name), el('dd', {}, value, suffix)];
      list.append(el('div', {}, ...parts));
    }
    return list;
  }
}
