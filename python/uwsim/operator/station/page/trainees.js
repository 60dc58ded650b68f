// The instructor's console: the trainees of several stations in one table, each with a link to its own page.
import './localize.js';
import './tips.js';
import './theme.js';
import { attempt, byId, clockText, el, fixed, toast, write } from './dom.js';
import { STRINGS } from './strings.js';
import { InstructorStation } from './wire/instructor_station.js';
import * as messages from './wire/messages.js';
import { bridgeUrl } from './wire/station.js';

const WORDS = STRINGS.trainees;
const ASK_MS = 500;
const OTHERS = 'rosbridge';
const token = decodeURIComponent(location.hash.slice(1));

// The address bar names the other stations, since the server lets the page connect to those alone.
const asked = new URLSearchParams(location.search);
const others = asked.getAll(OTHERS).filter((address) => URL.canParse(address));
asked.delete(OTHERS);
const own = bridgeUrl({ protocol: location.protocol, host: location.host, search: `?${asked}` });

// True if all stop is set for any vehicle.
const isStopped = (seen) => Boolean(seen?.vehicles.some(({ is_stopped }) => is_stopped));

function list(addresses) {
  const query = new URLSearchParams(asked);
  for (const address of addresses) query.append(OTHERS, address);
  location.search = String(query);
}

// One station: a row of the table.
class Trainee {
  #trouble = '';
  /** @type {any} */
  #seen = null; // the last overview
  pilot = el('td', {}, '–');
  task = el('td', {}, '–');
  clock = el('td', {}, '–');
  points = el('td', {}, '–');
  state = el('td', {}, '–');

  constructor(address) {
    this.station = new InstructorStation(address, STRINGS.instructor.title);
    const query = new URLSearchParams(asked);
    if (address !== own) query.set(OTHERS, address);
    this.name = el('a', {}, new URL(address).host);
    Object.assign(this.name, { href: `instructor.html?${query}#${encodeURIComponent(token)}`, target: '_blank' });
    this.pause = el('button', { type: 'button', onclick: () => this.#pauseOrResume() }, STRINGS.instructor.pause);
    const row = el('div', { className: 'instructor-row' }, this.pause);
    if (address !== own) {
      const remove = () => list(others.filter((each) => each !== address));
      row.append(el('button', { type: 'button', onclick: remove }, WORDS.remove));
    }
    this.element = el(
      'tr',
      {},
      el('th', { scope: 'row' }, this.name),
      this.pilot,
      this.task,
      this.clock,
      this.points,
      this.state,
      el('td', {}, row),
    );
    this.station.addEventListener('open', async () => (this.#trouble = await this.station.supervise(token)));
  }

  // Ask for what has happened, and show it.
  async look() {
    const { station } = this;
    if (station.isAdmitted && station.isRunning) {
      const found = await messages.overview(station.bridge).catch(() => null); // the connection was lost: it is shown
      if (found?.success) this.#seen = found;
    }
    this.#show();
  }

  #show() {
    const { state } = this.station;
    const seen = this.station.isRunning ? this.#seen : null;
    const exercise = seen?.exercise;
    const points = exercise && STRINGS.instructor.score(fixed(exercise.score, 1), fixed(exercise.points, 0));
    write(this.pilot, state.pilot ? this.station.nameOf(state.pilot) : WORDS.free);
    write(this.task, [state.scenario, exercise?.title].filter(Boolean).join(' · ') || '–');
    write(this.clock, seen ? clockText(seen.time_s, 1) : '–');
    write(this.points, points || '–');
    write(this.state, this.#standing(seen));
    write(this.pause, state.paused ? STRINGS.instructor.resume : STRINGS.instructor.pause);
    this.pause.disabled = !seen || this.station.isBlind;
    this.element.classList.toggle('is-stale', this.station.isBlind);
    this.element.classList.toggle('is-stopped', isStopped(seen));
  }

  // The most urgent of what is to be known of the trainee, in words.
  #standing(seen) {
    if (this.station.isBlind) return WORDS.lost;
    if (this.#trouble) return this.#trouble;
    if (!seen) return STRINGS.instructor.waiting;
    const { exercise, faults } = seen;
    const found = [];
    if (isStopped(seen)) found.push(STRINGS.allStop.allStop);
    if (exercise?.is_over) found.push(exercise.has_passed ? WORDS.passed : WORDS.notPassed);
    else if (exercise && !exercise.has_begun) found.push(WORDS.notBegun);
    else if (this.station.state.paused) found.push(WORDS.paused);
    if (faults.length) found.push(WORDS.faults(faults.join(', ')));
    return found.join(' · ') || WORDS.flies;
  }

  #pauseOrResume() {
    attempt(this.station.instruct(this.station.state.paused ? 'resume' : 'pause'));
  }
}

const trainees = [...new Set([own, ...others])].map((address) => new Trainee(address));
const address = el('input', { type: 'text', 'aria-label': WORDS.address, placeholder: WORDS.addressExample });
const add = (event) => {
  event.preventDefault();
  const given = address.value.trim();
  const found = /^wss?:/.test(given) ? given : `${new URL(own).protocol}//${given}`;
  if (URL.canParse(found)) list([...others, found]);
  else toast(WORDS.isNoAddress(found), 'error');
};
const heads = [WORDS.station, WORDS.pilot, WORDS.task, WORDS.clock, WORDS.points, WORDS.state, WORDS.acts];

write(byId('title'), WORDS.title);
byId('trainees').append(
  el(
    'section',
    { 'aria-label': WORDS.title, tabIndex: 0, className: 'trainees' },
    el(
      'table',
      {},
      el('thead', {}, el('tr', {}, ...heads.map((head) => el('th', { scope: 'col' }, head)))),
      el('tbody', {}, ...trainees.map(({ element }) => element)),
    ),
  ),
  el(
    'form',
    { className: 'instructor-row', onsubmit: add },
    el('label', { className: 'instructor-field' }, WORDS.address, address),
    el('button', { type: 'submit' }, WORDS.add),
  ),
);
setInterval(() => {
  for (const each of trainees) each.look();
}, ASK_MS);
