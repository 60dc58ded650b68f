// The start screen's list of exercises, each with a button that starts it.
import { byId, clockText, el, write } from './dom.js';

export class Exercises {
  constructor(station) {
    this.station = station;
    this.status = el('p', { className: 'flights-status', role: 'status' });
    this.list = el('ol', { className: 'flights-list' });
    this.element = byId('exercises');
    this.element.append(
      el('h2', { id: 'exercises-title' }, 'Exercises'),
      el('p', {}, 'In the order of the course. Time stands still until you begin.'),
      this.status,
      this.list,
    );
  }

  /** @param {import('./wire/messages.js').OfferedExercise[]} exercises */
  show(exercises) {
    this.list.replaceChildren(...exercises.map((each) => this.#row(each)));
  }

  #row({ name, title, brief, scenario, time_s }) {
    const button = el('button', { type: 'button', 'aria-label': `Start ${title}` }, 'Start');
    button.addEventListener('click', () => this.#start(name, button));
    return el(
      'li',
      { 'data-exercise': name },
      el(
        'div',
        {},
        el('b', {}, title),
        el('span', {}, `${scenario.replaceAll('_', ' ')}, ${clockText(time_s)}`),
        el('small', {}, brief),
      ),
      button,
    );
  }

  async #start(name, button) {
    button.disabled = true;
    write(this.status, 'Starting …');
    try {
      const answer = await this.station.start({ exercise_name: name });
      write(this.status, answer.success ? '' : answer.message);
    } catch (error) {
      write(this.status, error.message);
    }
    button.disabled = false;
  }
}
