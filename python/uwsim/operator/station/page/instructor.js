// The instructor's page: the truth, faults, water and light, saved moments, all parameters, and a log of actions.
import './localize.js';
import './tips.js';
import './theme.js';
import { attempt, byId, clockText, el, fixed, write } from './dom.js';
import { SceneEditor } from './editor/editor.js';
import { FaultForm } from './fault_form.js';
import { FaultTimes } from './fault_times.js';
import { Inspector, sliderScale } from './inspector.js';
import { TraineeView } from './instructor_view.js';
import { inWords } from './said.js';
import { STRINGS } from './strings.js';
import * as messages from './wire/messages.js';
import { InstructorStation } from './wire/instructor_station.js';
import { accepted } from './wire/rosbridge.js';
import { bridgeUrl } from './wire/station.js';

const WORDS = STRINGS.instructor;
const ASK_MS = 500;
// Parameters with a slider, and their titles.
const VISIBILITY = 'optics.visibility_m'; // by default that of the type of water
const SLIDERS = {
  [VISIBILITY]: WORDS.visibility,
  'optics.particles_per_m3': WORDS.haze,
  'optics.sun_elevation_deg': WORDS.sun,
  mission_time_s: WORDS.batteryLife,
};
const WATER = 'optics.jerlov';
const CURRENT = ['water.current_world_m_s.x', 'water.current_world_m_s.y'];
const RAD = Math.PI / 180;

const token = decodeURIComponent(location.hash.slice(1));
const station = new InstructorStation(bridgeUrl(location), WORDS.title);
const inspector = new Inspector(station);
const editor = new SceneEditor(station);
// The scene is edited while time stands still.
const editScene = async () => {
  if (station.state.paused || (await attempt(station.instruct('pause')))) editor.open('');
};
const button = (text, act) => el('button', { type: 'button', onclick: act }, text);
const section = (title, ...contents) => el('section', { 'aria-label': title }, el('h2', {}, title), ...contents);

const truth = el('ul', { className: 'instructor-list' });
const score = el('p', { className: 'instructor-score' });
const goals = el('ul', { className: 'instructor-list' });
const exercise = section(WORDS.exercise, score, goals);
const edits = button(STRINGS.menu.editTheScene, editScene);
const pause = button(WORDS.pause, () => attempt(station.instruct(station.state.paused ? 'resume' : 'pause')));
const moments = el('div', { className: 'instructor-row' });
const faults = el('div', { className: 'instructor-row' });
const log = el('ol', { className: 'instructor-log', tabIndex: 0 });
const times = new FaultTimes();
const trainee = new TraineeView(station);
const form = new FaultForm(({ in_s, ...args }) =>
  attempt(station.command('inject_fault', in_s > 0 ? { ...args, at_s: seen.time_s + in_s } : args)),
);
const towards = el('input', { type: 'number', min: 0, max: 360, step: 5, value: 0, 'aria-label': WORDS.sets });
const flows = el('input', { type: 'number', min: 0, max: 5, step: 0.05, value: 0, 'aria-label': WORDS.flows });
// A current is named by the direction into which it flows, clockwise from north.
const setCurrent = () => {
  const [angle, speed] = [Number(towards.value) * RAD, Number(flows.value)];
  const parts = [speed * Math.sin(angle), speed * Math.cos(angle)].map((value) => +value.toFixed(6));
  attempt(station.setParameters({ [CURRENT[0]]: parts[0], [CURRENT[1]]: parts[1] }));
};
const note = el('input', { type: 'text', maxLength: 200, 'aria-label': WORDS.message, autocomplete: 'off' });
const send = (event) => {
  event.preventDefault();
  attempt(station.instruct('message', { text: note.value.trim() }));
};
const holder = el('p', { role: 'status' });
const givers = el('div', { className: 'instructor-row' });
const ends = button(WORDS.endAttempt, () => attempt(station.instruct('end')));
const sliders = Object.entries(SLIDERS).map(([name, title]) => {
  const value = el('output', { className: 'reading' }, '–');
  const input = el('input', { type: 'range', 'aria-label': title });
  const row = el('label', { className: 'instructor-slider', hidden: true }, title, input, value);
  const found = { name, unit: '', scale: /** @type {any} */ (null), value, input, row };
  const chosen = () => found.scale?.valueAt(Number(input.value));
  input.addEventListener('input', () => write(value, `${chosen()} ${found.unit}`));
  input.addEventListener('change', () => attempt(station.setParameters({ [name]: chosen() })));
  return found;
});
const water = el('select', {
  'aria-label': WORDS.waterType,
  onchange: () => attempt(station.setParameters({ [WATER]: water.value, [VISIBILITY]: null })),
});

byId('instructor').append(
  section(WORDS.trainee, trainee.choice, trainee.element, trainee.link.element),
  section(WORDS.truth, truth),
  section(
    WORDS.controls,
    holder,
    givers,
    el(
      'form',
      { className: 'instructor-row', onsubmit: send },
      el('label', { className: 'instructor-field' }, WORDS.message, note),
      el('button', { type: 'submit' }, WORDS.send),
    ),
  ),
  exercise,
  section(
    WORDS.time,
    el(
      'div',
      { className: 'instructor-row' },
      pause,
      edits,
      button(WORDS.restart, () => attempt(station.instruct('restart'))),
      button(WORDS.save, () => attempt(station.instruct('save_moment'))),
      ends,
    ),
    el('h3', {}, WORDS.moments),
    moments,
  ),
  section(WORDS.faults, form.element, el('h3', {}, WORDS.active), faults, el('h3', {}, WORDS.timeLine), times.element),
  section(
    WORDS.water,
    el(
      'div',
      { className: 'instructor-row' },
      el('label', { className: 'instructor-field' }, WORDS.sets, towards),
      el('label', { className: 'instructor-field' }, WORDS.flows, flows),
      button(WORDS.set, setCurrent),
    ),
    ...sliders.map(({ row }) => row),
    el('label', { className: 'instructor-slider' }, WORDS.waterType, water, el('span')),
  ),
  section(WORDS.log, log),
);
write(byId('inspect'), WORDS.parameters);
write(byId('title'), WORDS.title);
const all = el('a', {}, STRINGS.trainees.title);
all.href = `trainees.html${location.search}${location.hash}`;
byId('clock').before(all);

let seen = null; // the last overview
let offered = ''; // the vehicle's parts that the form of faults offers
station.addEventListener('open', () => supervise());
station.addEventListener('session', () => {
  showParameters();
  if (station.description) trainee.begin(station.description);
});
station.addEventListener('state', () => showControls());
station.addEventListener('description', () => showParameters());
setInterval(() => look(), ASK_MS);

function complain(text) {
  write(byId('trouble'), text);
  byId('trouble').hidden = text === '';
}

async function supervise() {
  complain(await station.supervise(token));
  if (station.isAdmitted && station.description) showParameters();
  station.dispatchEvent(new Event('state'));
}

async function look() {
  if (!station.isAdmitted || !station.isRunning) return;
  try {
    const found = await messages.overview(station.bridge);
    if (!found.success) return;
    seen = found;
    show();
    const parts = JSON.stringify(
      found.vehicles.map(({ name, sensors, thrusters, cameras }) => [name, sensors, thrusters, cameras]),
    );
    if (parts === offered) return;
    offered = parts;
    form.offer((await accepted(messages.faultKinds(station.bridge))).kinds, found.vehicles);
  } catch {
    /* the connection is lost: keep the last overview, with its time */
  }
}

// Show the pilot, and buttons that give the controls to another member.
function showControls() {
  const { pilot, member_ids: ids } = station.state;
  write(holder, pilot ? WORDS.holds(station.nameOf(pilot)) : WORDS.noPilot);
  buttons(givers, [...ids.filter((id) => id !== pilot), ''], (id) => [
    id === station.id ? WORDS.take : id ? WORDS.giveTo(station.nameOf(id)) : WORDS.free,
    () => attempt(station.instruct('hand_over', { to: id })),
  ]);
}

function rewrite(list, texts) {
  if (list.children.length !== texts.length) list.replaceChildren(...texts.map(() => el('li')));
  texts.forEach((text, k) => write(list.children[k], text));
}

function show() {
  write(byId('title'), `${WORDS.title}: ${station.state.scenario}`);
  write(byId('clock'), clockText(seen.time_s, 1));
  write(pause, station.state.paused ? WORDS.resume : WORDS.pause);
  edits.hidden = !station.description || station.description.is_fixed; // a given scenario, or an exercise, is not edited
  rewrite(
    truth,
    seen.vehicles.map((vehicle) =>
      [
        vehicle.name,
        WORDS.place(vehicle.position_world_m.map((value) => fixed(value, 1)).join(', ')),
        WORDS.depth(fixed(-vehicle.position_world_m[2], 1)),
        WORDS.altitude(fixed(vehicle.altitude_m, 1)),
        WORDS.heading(fixed(vehicle.heading_deg, 0)),
        WORDS.speed(fixed(vehicle.speed_m_s, 2)),
        WORDS.lost(fixed(vehicle.battery_percent, 0)),
        WORDS.collisions(vehicle.collisions),
      ].join(' · '),
    ),
  );
  exercise.hidden = !seen.exercise;
  if (seen.exercise) {
    write(score, WORDS.score(fixed(seen.exercise.score, 1), fixed(seen.exercise.points, 0)));
    rewrite(
      goals,
      seen.exercise.goals.map(({ title, share }) => `${title}: ${fixed(100 * share, 0)} %`),
    );
  }
  buttons(faults, seen.faults, (name) => [WORDS.end(name), () => attempt(station.command('end_fault', { name }))]);
  if (seen.faults.length === 0) write(faults, WORDS.noFaults);
  times.show(seen.fault_times, seen.time_s);
  ends.hidden = !seen.exercise;
  ends.disabled = !seen.exercise?.has_begun || seen.exercise.is_over;
  buttons(
    moments,
    seen.moments.map(({ name, time_s }) => `${name}|${time_s}`),
    (key) => {
      const [name, time_s] = key.split('|');
      return [
        WORDS.returnTo(name, clockText(Number(time_s), 1)),
        () => attempt(station.instruct('return_to', { name })),
      ];
    },
  );
  rewrite(
    log,
    seen.log.map(({ time_s, clock, by, text: said, details }) => {
      const given = details.length ? ` – ${inWords(details)}` : '';
      return `${clock.slice(11, 19)} (${clockText(time_s, 1)}) ${by}: ${said}${given}`;
    }),
  );
}

// Update the buttons, one for each key. Unchanged keys keep their buttons and the focus.
function buttons(row, keys, made) {
  if (row.dataset.keys === keys.join()) return;
  row.dataset.keys = keys.join();
  row.replaceChildren(...keys.map((key) => button(...made(key))));
}

async function showParameters() {
  if (!station.isAdmitted) return;
  const described = new Map((await station.described()).map((parameter) => [parameter.name, parameter]));
  for (const slider of sliders) {
    const { input, row } = slider;
    const parameter = described.get(slider.name);
    const scale = parameter && sliderScale(parameter);
    row.hidden = !scale;
    if (!scale || document.activeElement === input) continue;
    slider.scale = scale;
    slider.unit = parameter.unit;
    Object.assign(input, scale.ends, { value: scale.placeOf(parameter.value) });
    write(slider.value, `${+Number(parameter.value).toFixed(3)} ${parameter.unit}`);
  }
  const { value, choices = [] } = described.get(WATER) ?? {};
  if (water.options.length === 0)
    water.append(
      ...choices.map((name) => el('option', { value: name }, WORDS.sees(name, fixed(station.visibility_m[name], 1)))),
    );
  if (value) water.value = value;
  const [x, y] = CURRENT.map((name) => Number(described.get(name)?.value ?? 0));
  if (document.activeElement !== towards && document.activeElement !== flows) {
    flows.value = String(+Math.hypot(x, y).toFixed(3));
    if (x || y) towards.value = String(Math.round((Math.atan2(x, y) / RAD + 360) % 360));
  }
}

globalThis.instructor = { station, inspector }; // for the browser's console and tests
