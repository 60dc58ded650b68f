// The current exercise, if any: its task, score so far, goals, broken limits, and the score sheet at the end.
import { attempt, clockText, el, write } from '../dom.js';
import * as messages from '../wire/messages.js';

const AIDS = { autopilot: 'plans on the chart', hold: 'holds', program: 'programs' };
/** @type {Record<string, string>} */
const REASONS = {
  altitude: 'Too near the bed',
  area: 'Outside the area',
  collision: 'Collision',
  depth: 'Too deep',
  reports: 'Too many notes',
  speed: 'Too fast',
  tangled: 'Tether round an obstacle',
};
const ASK_MS = 1000;
const text = (points) => String(+points.toFixed(1));

// The aids that may be used or were used, with their cost and the seconds of use.
function aidsText(aids) {
  if (aids.length === 0) return 'No aids are allowed.';
  const each = aids.map((aid) => {
    const notes = [
      aid.cost_per_s > 0 ? `${+aid.cost_per_s.toFixed(3)} points per second` : '',
      aid.used_s > 0 ? `used for ${text(aid.used_s)} s` : '',
    ].filter(Boolean);
    return AIDS[aid.kind] + (notes.length ? ` (${notes.join(', ')})` : '');
  });
  return `Aids: ${each.join(', ')}`;
}

export class ExercisePanel {
  #timer = 0;
  /** @type {import('../wire/messages.js').ExerciseState | null} */
  state = null; // as last reported

  constructor(station) {
    this.station = station;
    this.left = el('small');
    this.score = el('output', { className: 'exercise-score', 'aria-label': 'Points' });
    this.brief = el('p');
    this.goals = el('ul', { className: 'exercise-goals' });
    this.begins = el(
      'button',
      {
        type: 'button',
        className: 'primary exercise-begin',
        onclick: () => this.beginAttempt(),
        'aria-keyshortcuts': 'Enter',
      },
      'Begin',
    );
    this.waits = el('div', { hidden: true }, el('p', {}, 'Time stands still until you begin.'), this.begins);
    this.aids = el('p', { className: 'exercise-aids' });
    this.invalid = el('p', { className: 'exercise-note', role: 'status' });
    this.note = el('p', { className: 'exercise-note', role: 'status' });
    this.losses = el('ul', { className: 'exercise-goals exercise-losses' });
    this.again = el('button', { type: 'button', onclick: () => attempt(this.station.control('restart')) }, 'Again');
    this.next = el('button', { type: 'button', className: 'primary', onclick: () => this.#next() });
    this.after = el('div', { className: 'exercise-after', hidden: true }, this.again, this.next);
    this.sheet = el('a', { className: 'exercise-sheet', download: 'sheet.html', hidden: true }, 'Score sheet');
    this.title = el('span', {}, 'Exercise');
    this.element = el(
      'section',
      { id: 'exercise', hidden: true },
      el('h2', {}, this.title, this.left),
      this.score,
      el('details', { open: true }, el('summary', {}, 'Task'), this.brief),
      this.waits,
      this.goals,
      this.aids,
      this.invalid,
      this.losses,
      this.note,
      this.after,
      el('div', { className: 'exercise-files' }, this.sheet),
    );
  }

  begin({ has_exercise }) {
    clearInterval(this.#timer);
    this.station.awaitsBegin = false;
    this.element.hidden = !has_exercise;
    if (!has_exercise) return;
    this.#timer = setInterval(() => this.#ask(), ASK_MS);
    this.#ask();
  }

  // Begin the attempt.
  async beginAttempt() {
    await attempt(this.station.control('begin'));
    this.#ask();
  }

  // Run the next exercise of the course.
  async #next() {
    this.next.disabled = true;
    await attempt(this.station.start({ exercise_name: this.state?.next_name }));
    this.next.disabled = false;
  }

  async #ask() {
    if (this.station.isBlind) return;
    try {
      const state = await messages.exercise(this.station.bridge);
      if (state.success) this.#show(state);
    } catch {
      /* the banner reports a lost connection */
    }
  }

  #show(state) {
    this.state = state;
    write(this.title, state.title);
    write(this.left, `${clockText(Math.max(state.limit_s - state.time_s, 0))} left`);
    write(this.score, `${text(state.score)} of ${text(state.points)} points`);
    write(this.brief, state.brief);
    this.station.awaitsBegin = !state.has_begun;
    this.waits.hidden = state.has_begun;
    this.begins.disabled = !this.station.isPilot;
    write(this.aids, aidsText(state.aids));
    write(this.invalid, state.is_valid ? '' : `Not valid: ${state.invalid_because}`);
    if (this.goals.children.length !== state.goals.length) {
      this.goals.replaceChildren(...state.goals.map(({ title }) => el('li', {}, el('span', {}, title), el('b'))));
    }
    state.goals.forEach(({ points, share }, k) => {
      const item = /** @type {HTMLElement} */ (this.goals.children[k]);
      item.dataset.met = String(share >= 1);
      write(item.lastChild, `${text(points * share)} / ${text(points)}`);
    });
    const losses = lossTexts(state);
    if (this.losses.children.length !== losses.length) this.losses.replaceChildren(...losses.map(() => el('li')));
    losses.forEach((loss, k) => write(this.losses.children[k], loss));
    this.after.hidden = !state.is_over;
    this.again.disabled = this.next.disabled = !this.station.isPilot;
    this.again.hidden = !this.station.may('restart');
    this.next.hidden = state.next_name === '';
    write(this.next, `Next: ${state.next_title}`);
    const notes = [
      state.lost > 0 ? `${text(state.lost)} points lost` : '',
      state.is_over ? ended(state) : '',
      state.error,
    ];
    write(this.note, notes.filter(Boolean).join('. '));
    this.sheet.hidden = !state.has_sheet;
    this.sheet.href = this.station.href('/exercise/sheet.html');
  }
}

// The reasons for which points were lost: broken limits, and aids that cost.
function lossTexts({ broken, aids }) {
  return [
    ...broken.map(
      ({ kind, title, cost, time_s }) =>
        `−${text(cost)}: ${[REASONS[kind] ?? title, REASONS[kind] && /\d/.test(title) ? `(${title})` : ''].join(' ').trim()}, at ${clockText(time_s)}`,
    ),
    ...aids
      .filter(({ cost }) => cost > 0)
      .map(({ kind, cost, used_s }) => `−${text(cost)}: ${AIDS[kind]}, used for ${text(used_s)} s`),
  ];
}

function ended({ has_passed, is_valid, ended_because }) {
  if (has_passed) return `Passed: ${ended_because}`;
  return is_valid ? `Not passed: ${ended_because}` : `Ended: ${ended_because}`;
}
