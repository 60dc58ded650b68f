// The start screen's list of exercises, each with a button that starts it.
import { byId, clockText, draw } from './dom.js';
import { html, signal } from './vendor/preact.js';

export class Exercises {
  /** @type {{ value: import('./wire/messages.js').OfferedExercise[] }} */
  #offered = signal([]);
  #status = signal('');
  #starting = signal(''); // the name of one

  constructor(station) {
    this.station = station;
    draw(byId('exercises'), () => this.#view());
  }

  show(exercises) {
    this.#offered.value = exercises;
  }

  #view() {
    const row = ({ name, title, brief, scenario, time_s }) => html`
      <li key=${name} data-exercise=${name}>
        <div>
          <b>${title}</b><span>${scenario.replaceAll('_', ' ')}, ${clockText(time_s)}</span><small>${brief}</small>
        </div>
        <button type="button" aria-label="Start ${title}" disabled=${this.#starting.value === name}
          onClick=${() => this.#start(name)}>Start</button>
      </li>
    `;
    return html`
      <h2 id="exercises-title">Exercises</h2>
      <p>In the order of the course. Time stands still until you begin.</p>
      <p class="flights-status" role="status">${this.#status.value}</p>
      <ol class="flights-list">${this.#offered.value.map(row)}</ol>
    `;
  }

  async #start(name) {
    this.#starting.value = name;
    this.#status.value = 'Starting …';
    try {
      const answer = await this.station.start({ exercise_name: name });
      this.#status.value = answer.success ? '' : answer.message;
    } catch (error) {
      this.#status.value = error.message;
    }
    this.#starting.value = '';
  }
}
