// The current exercise, if any: its task, score so far, goals, broken limits, and the score sheet at the end.
import { attempt, clockText } from '../dom.js';
import { html, signal } from '../vendor/preact.js';
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
  #isShown = signal(false);
  #isStarting = signal(false); // the next exercise
  /** @type {{ value: import('../wire/messages.js').ExerciseState | null }} */
  #state = signal(null); // as last reported

  constructor(station) {
    this.station = station;
  }

  begin({ has_exercise }) {
    clearInterval(this.#timer);
    this.station.awaitsBegin = false;
    this.#isShown.value = has_exercise;
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
    this.#isStarting.value = true;
    await attempt(this.station.start({ exercise_name: this.#state.value?.next_name }));
    this.#isStarting.value = false;
  }

  async #ask() {
    if (this.station.isBlind) return;
    try {
      const state = await messages.exercise(this.station.bridge);
      if (!state.success) return;
      this.#state.value = state;
      this.station.awaitsBegin = !state.has_begun;
    } catch {
      /* the banner reports a lost connection */
    }
  }

  view() {
    const state = this.#state.value;
    if (!this.#isShown.value || !state) return html`<section id="exercise" hidden />`;
    const { station } = this;
    const mayNot = !station.isPilot;
    const goal = ({ title, points, share }) => html`
      <li data-met=${share >= 1}><span>${title}</span><b>${text(points * share)} / ${text(points)}</b></li>
    `;
    const notes = [
      state.lost > 0 ? `${text(state.lost)} points lost` : '',
      state.is_over ? ended(state) : '',
      state.error,
    ];
    return html`
      <section id="exercise">
        <h2><span>${state.title}</span><small>${clockText(Math.max(state.limit_s - state.time_s, 0))} left</small></h2>
        <output class="exercise-score" aria-label="Points">${text(state.score)} of ${text(state.points)} points</output>
        <details open><summary>Task</summary><p>${state.brief}</p></details>
        <div hidden=${state.has_begun}>
          <p>Time stands still until you begin.</p>
          <button type="button" class="primary exercise-begin" aria-keyshortcuts="Enter" disabled=${mayNot}
            onClick=${() => this.beginAttempt()}>Begin</button>
        </div>
        <ul class="exercise-goals">${state.goals.map(goal)}</ul>
        <p class="exercise-aids">${aidsText(state.aids)}</p>
        <p class="exercise-note" role="status">${state.is_valid ? '' : `Not valid: ${state.invalid_because}`}</p>
        <ul class="exercise-goals exercise-losses">${lossTexts(state).map((loss) => html`<li>${loss}</li>`)}</ul>
        <p class="exercise-note" role="status">${notes.filter(Boolean).join('. ')}</p>
        <div class="exercise-after" hidden=${!state.is_over}>
          <button type="button" hidden=${!station.may('restart')} disabled=${mayNot}
            onClick=${() => attempt(station.control('restart'))}>Again</button>
          <button type="button" class="primary" hidden=${state.next_name === ''}
            disabled=${mayNot || this.#isStarting.value} onClick=${() => this.#next()}>
            Next: ${state.next_title}
          </button>
        </div>
        <div class="exercise-files">
          <a class="exercise-sheet" download="sheet.html" hidden=${!state.has_sheet}
            href=${station.href('/exercise/sheet.html')}>Score sheet</a>
        </div>
      </section>
    `;
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
