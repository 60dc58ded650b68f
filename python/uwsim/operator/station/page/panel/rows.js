// The rows of the panel: how a gauge is shown, whose table is Python's, and the values computed from the orientation.
import { attitude } from '../attitude.js';
import { capital, fixed, part } from '../dom.js';
import { inUnit } from '../units.js';
import { html } from '../vendor/preact.js';
import { GAUGES } from '../wire/messages.js';

/** Words of gauges that are not said as they are called.
 * @type {Record<string, string>}
 */
const NAMES = {
  acceleration: 'Accel.',
  angular_acceleration: 'Ang. accel.',
  angular_speed: 'Turning',
  link_delay: 'Sound delay',
  temperature: 'Water',
  to_port: 'Port side',
  to_station: 'Station',
};
const DEG = 180 / Math.PI;
export const LENGTH = 'length'; // in the pilot's unit
// The unit, the factor and the decimals with which a gauge in an SI unit is shown; others are shown as they are.
const SHOWN = {
  m: [LENGTH, 1, 1],
  'm/s': ['m/s', 1, 2],
  'rad/s': ['°/s', DEG, 1],
  'm/s2': ['m/s²', 1, 2],
  'rad/s2': ['°/s²', DEG, 1],
  'deg C': ['°C', 1, 1],
  Pa: ['kPa', 1e-3, 1],
  s: ['ms', 1000, 0],
};
const LINEAR = ['ahead', 'to port', 'up'];
const ANGULAR = ['roll', 'pitch', 'yaw'];

// A range, or that nothing is within the sensor's reach.
function range(range_m, reach_m = Infinity) {
  if (range_m === Infinity) return 'none';
  return range_m >= reach_m ? `> ${fixed(inUnit(reach_m), 0)}` : fixed(inUnit(range_m), 1);
}

const Row = part(
  ({ name, unit, text, title, isOld }) => html`
    <div>
      <dt>${name}</dt>
      <dd class=${isOld ? 'is-stale' : ''}>
        <span title=${title}>${text}</span>${unit && html`<span class="unit">${unit}</span>`}
      </dd>
    </div>
  `,
);

// A row of a list: the name of a value, its unit, its text and its tooltip.
export const valueRow = (name, unit, text, title = '', isOld = false) =>
  html`<${Row} ...${{ name, unit, text, title, isOld }} />`;

// A group of links to files of some kinds. of: the attributes of one.
export const downloads = (label, kinds, of) => html`
  <div class="downloads" role="group" aria-label=${label}>
    ${kinds.map((kind) => html`<a ...${of(kind)}>.${kind}</a>`)}
  </div>
`;

const size = (value) => (typeof value === 'number' ? value : Math.hypot(...value));

// The row of a gauge: name, unit, a function of the telemetry m and the reach of each range, a function of m for the
// tooltip, and the field of the telemetry, whose age is known.
export function gaugeRow({ name, word = name, unit }) {
  const [shown, factor, digits] = SHOWN[unit] ?? [unit, 1, -1];
  const text = (value) =>
    digits < 0 && Number.isFinite(value) ? String(+value.toPrecision(4)) : fixed(factor * value, Math.max(0, digits));
  const axes = unit.startsWith('rad') ? ANGULAR : LINEAR;
  return [
    NAMES[word] ?? capital(word),
    shown,
    (m, reaches) => (shown === LENGTH ? range(m[name], reaches[name]) : text(size(m[name]))),
    // such as "1.20 ahead, -0.10 to port, 0.00 up"
    (m) =>
      typeof m[name] === 'number' ? '' : axes.map((axis, k) => `${fixed(factor * m[name][k], 2)} ${axis}`).join(', '),
    name,
  ];
}

const gauges = (...lists) => GAUGES.filter(({ list }) => lists.includes(list)).map(gaugeRow);

// Format an angle to a side: "2.0° S" is to starboard.
function sided(value, positive, negative) {
  const text = fixed(Math.abs(value), 1);
  return Number(text) ? `${text}° ${value > 0 ? positive : negative}` : `${text}°`;
}

const AXES = ['East', 'North', 'Up'];
export const BIG = [
  ...gauges('big'),
  ['Heading', '°', (m) => String(Math.round(attitude(m.orientation).heading_deg) % 360).padStart(3, '0')],
];
export const MOTION = [
  ...gauges('motion'),
  ['Roll', '', (m) => sided(attitude(m.orientation).roll_deg, 'S', 'P')],
  ['Pitch', '°', (m) => fixed(attitude(m.orientation).nose_up_deg, 1)],
];
export const POSITION = AXES.map((axis, k) => [axis, 'm', (m) => fixed(m.position[k], 1), null, 'position']);
export const AROUND = [...gauges('around', 'water'), ['Collisions', '', (m) => String(m.collisions)]];
