// The start screen's list of recorded flights, each with a button to replay it or the reason why this is impossible.
import { byId, clockText, el, toast, write } from '../dom.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.flights;

// "23 Nov 2026, 04:12", in the user's time zone; '' if unknown.
export function begunText(begun) {
  const at = new Date(begun);
  const { lang } = document.documentElement;
  /** @type {Intl.DateTimeFormatOptions} */
  const style = { dateStyle: 'medium', timeStyle: 'medium' };
  return Number.isNaN(at.getTime()) ? '' : at.toLocaleString(lang === 'en' ? 'en-GB' : lang, style);
}

export class Flights {
  #isOpening = false;
  #trouble = '';
  /** @type {Map<string, Element>} */
  #rows = new Map(); // by their entries

  constructor(station) {
    this.station = station;
    this.status = el('p', { className: 'flights-status', role: 'status' });
    this.none = el('p', {}, WORDS.none);
    this.list = el('ul', { className: 'flights-list' });
    this.element = byId('flights');
    this.element.append(
      el('h2', { id: 'flights-title' }, WORDS.title),
      el('p', {}, WORDS.hint),
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
    const duration = cut_off ? WORDS.cutOff(clockText(duration_s)) : clockText(duration_s);
    const about = scenario ? WORDS.about(scenario, duration, (size_bytes / 1e6).toFixed(1)) : '';
    const wrong = el('small', { className: 'wrong', role: 'status' }, refused);
    const replay = el(
      'button',
      { type: 'button', 'aria-label': WORDS.replayOf(begunText(begun) || name) },
      WORDS.replay,
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
        branched_from ? el('small', {}, WORDS.branch(branched_from)) : null,
        exercise ? el('small', {}, WORDS.exercise(exercise)) : null,
        from_log ? el('small', {}, WORDS.fromLog(from_log)) : null,
        wrong,
      ),
      replay,
    );
  }

  // The server reads the whole flight first, and refuses it if it cannot be repeated.
  async #open(name, wrong, button) {
    if (this.#isOpening) return;
    this.#isOpening = true;
    this.#showMessage(WORDS.reading);
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
