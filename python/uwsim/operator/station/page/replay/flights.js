// The start screen's list of recorded flights, each with a button to replay it or the reason why this is impossible.
import { byId, clockText, el, toast, write } from '../dom.js';

// "23 Nov 2026, 04:12", in the user's time zone; '' if unknown.
function begunText(begun) {
  const at = new Date(begun);
  /** @type {Intl.DateTimeFormatOptions} */
  const style = { dateStyle: 'medium', timeStyle: 'medium' };
  return Number.isNaN(at.getTime()) ? '' : at.toLocaleString('en-GB', style);
}

export class Flights {
  #isOpening = false;
  #trouble = '';
  /** @type {Map<string, Element>} */
  #rows = new Map(); // by their entries

  constructor(station) {
    this.station = station;
    this.status = el('p', { className: 'flights-status', role: 'status' });
    this.none = el('p', {}, 'No flights yet: each flight is recorded.');
    this.list = el('ul', { className: 'flights-list' });
    this.element = byId('flights');
    this.element.append(
      el('h2', { id: 'flights-title' }, 'Flights'),
      el('p', {}, 'Every flight is recorded automatically. The oldest are deleted when there are too many.'),
      this.status,
      this.none,
      this.list,
    );
    station.addEventListener('state', () => this.#warn());
  }

  // flights: the entries of the catalog. Rows that have not changed stay in place, so that no click on one is lost.
  show(flights = []) {
    this.element.classList.toggle('is-empty', flights.length === 0);
    this.none.hidden = flights.length > 0;
    const before = [...this.#rows.values()];
    const keys = flights.map((flight) => JSON.stringify(flight));
    this.#rows = new Map(keys.map((key, k) => [key, this.#rows.get(key) ?? this.#row(flights[k])]));
    const rows = [...this.#rows.values()];
    for (const old of before) if (!rows.includes(old)) old.remove();
    rows.forEach((row, k) => {
      if (this.list.children[k] !== row) this.list.insertBefore(row, this.list.children[k] ?? null);
    });
  }

  #row(flight) {
    const { name, scenario, begun, duration_s, cut_off, size_bytes, branched_from, from_log, exercise, refused } =
      flight;
    const title = el('b', {}, begunText(begun) || name);
    const duration = cut_off ? `cut off at ${clockText(duration_s)}` : clockText(duration_s);
    const about = scenario ? `${scenario}, ${duration}, ${(size_bytes / 1e6).toFixed(1)} MB` : '';
    const wrong = el('small', { className: 'wrong', role: 'status' }, refused);
    const replay = el(
      'button',
      { type: 'button', 'aria-label': `Replay the flight of ${begunText(begun) || name}` },
      'Replay',
    );
    replay.disabled = refused !== '';
    replay.addEventListener('click', () => this.#open(name, wrong, replay));
    return el(
      'li',
      { 'data-flight': name },
      el(
        'div',
        {},
        title,
        el('span', {}, about),
        branched_from ? el('small', {}, `flown on from ${branched_from}`) : null,
        exercise ? el('small', {}, `exercise: ${exercise}`) : null,
        from_log ? el('small', {}, `from the log ${from_log}`) : null,
        wrong,
      ),
      replay,
    );
  }

  // The server reads the whole flight first, and refuses it if it cannot be repeated.
  async #open(name, wrong, button) {
    if (this.#isOpening) return;
    this.#isOpening = true;
    this.#showMessage('Reading the flight …');
    try {
      const answer = await this.station.start({ flight: name, speed: 1 });
      const why = answer.success ? '' : (answer.errors?.flight ?? answer.message);
      write(wrong, why);
      button.disabled = Boolean(answer.errors?.flight);
      this.#showMessage('');
    } catch (error) {
      this.#showMessage(error.message, 'error');
    }
    this.#isOpening = false;
  }

  #showMessage(text, kind = '') {
    write(this.status, text);
    this.status.dataset.kind = kind;
  }

  // Report once why a flight is not recorded.
  #warn() {
    const trouble = this.station.state.flight_trouble ?? '';
    if (trouble && trouble !== this.#trouble) toast(trouble, 'error');
    this.#trouble = trouble;
  }
}
