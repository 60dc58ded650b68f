// The start screen's list of recorded flights, each with a button to replay it or the reason why this is impossible.
import { byId, clockText, draw, toast } from '../dom.js';
import { html, signal } from '../vendor/preact.js';

// "23 Nov 2026, 04:12", in the user's time zone; '' if unknown.
function begunText(begun) {
  const at = new Date(begun);
  /** @type {Intl.DateTimeFormatOptions} */
  const style = { dateStyle: 'medium', timeStyle: 'medium' };
  return Number.isNaN(at.getTime()) ? '' : at.toLocaleString('en-GB', style);
}

export class Flights {
  #flights = signal([]); // the entries of the catalog
  #answers = signal({}); // of the server, by the flights' names: { why, isRefused }
  #status = signal({ text: '', kind: '' });
  #isOpening = false;
  #trouble = '';

  constructor(station) {
    this.station = station;
    draw(byId('flights'), () => this.#view());
    station.addEventListener('state', () => this.#warn());
  }

  show(flights = []) {
    byId('flights').classList.toggle('is-empty', flights.length === 0);
    this.#flights.value = flights;
  }

  #view() {
    const [flights, { text, kind }] = [this.#flights.value, this.#status.value];
    return html`
      <h2 id="flights-title">Flights</h2>
      <p>Every flight is recorded automatically. The oldest are deleted when there are too many.</p>
      <p class="flights-status" role="status" data-kind=${kind}>${text}</p>
      <p hidden=${flights.length > 0}>No flights yet: each flight is recorded.</p>
      <ul class="flights-list">${flights.map((flight) => this.#row(flight))}</ul>
    `;
  }

  #row({ name, scenario, begun, duration_s, cut_off, size_bytes, branched_from, from_log, exercise, refused }) {
    const { why = refused, isRefused = refused !== '' } = this.#answers.value[name] ?? {};
    const title = begunText(begun) || name;
    const duration = cut_off ? `cut off at ${clockText(duration_s)}` : clockText(duration_s);
    return html`
      <li key=${name} data-flight=${name}>
        <div>
          <b>${title}</b>
          <span>${scenario && `${scenario}, ${duration}, ${(size_bytes / 1e6).toFixed(1)} MB`}</span>
          ${branched_from && html`<small>flown on from ${branched_from}</small>`}
          ${exercise && html`<small>exercise: ${exercise}</small>`}
          ${from_log && html`<small>from the log ${from_log}</small>`}
          <small class="wrong" role="status">${why}</small>
        </div>
        <button type="button" aria-label="Replay the flight of ${title}" disabled=${isRefused}
          onClick=${() => this.#open(name)}>Replay</button>
      </li>
    `;
  }

  // The server reads the whole flight first, and refuses it if it cannot be repeated.
  async #open(name) {
    if (this.#isOpening) return;
    this.#isOpening = true;
    this.#say('Reading the flight …');
    try {
      const answer = await this.station.start({ flight: name, speed: 1 });
      const why = answer.success ? '' : (answer.errors?.flight ?? answer.message);
      this.#answers.value = { ...this.#answers.value, [name]: { why, isRefused: Boolean(answer.errors?.flight) } };
      this.#say('');
    } catch (error) {
      this.#say(error.message, 'error');
    }
    this.#isOpening = false;
  }

  #say(text, kind = '') {
    this.#status.value = { text, kind };
  }

  // Report once why a flight is not recorded.
  #warn() {
    const trouble = this.station.state.flight_trouble ?? '';
    if (trouble && trouble !== this.#trouble) toast(trouble, 'error');
    this.#trouble = trouble;
  }
}
