// The debriefing film of a flight that holds an attempt at an exercise: a button that makes it, then a link to it.
import { el, write } from '../dom.js';
import { LANGUAGE, STRINGS } from '../strings.js';
import * as messages from '../wire/messages.js';

const WORDS = STRINGS.film;
const ASK_MS = 1000;

export class Film {
  #timer = 0;
  #flight = '';

  // of: what to call the flight for a screen reader, where several are listed.
  constructor(station, of = '') {
    this.station = station;
    this.make = el('button', {
      type: 'button',
      className: 'film-make',
      hidden: true,
      onclick: () => this.#ask(LANGUAGE),
    });
    this.link = el('a', { className: 'film-link', target: '_blank', rel: 'noopener', hidden: true }, WORDS.film);
    this.trouble = el('small', { className: 'wrong', role: 'status' });
    if (of) this.make.setAttribute('aria-description', of);
    if (of) this.link.setAttribute('aria-label', WORDS.filmOf(of));
    this.element = el('div', { className: 'film', hidden: true }, this.make, this.link, this.trouble);
  }

  // Show the film of a flight; none for ''.
  follow(flight) {
    if (flight === this.#flight) return;
    this.#flight = flight;
    this.show({ film: '' });
    if (flight) this.#ask(null);
  }

  // Show a film's state, as in an entry of the catalog.
  show({ name = this.#flight, film, film_share = 0, film_trouble = '' }) {
    this.#flight = name;
    clearTimeout(this.#timer);
    if (film === 'making') this.#timer = setTimeout(() => this.#ask(null), ASK_MS);
    this.element.hidden = film === '';
    this.make.hidden = film === 'made';
    this.make.disabled = film === 'making';
    write(this.make, film === 'making' ? WORDS.making(Math.floor(100 * film_share)) : WORDS.make);
    this.link.hidden = film !== 'made';
    this.link.href = this.station.href(`/film/${encodeURIComponent(this.#flight)}.webp`);
    write(this.trouble, film_trouble);
  }

  // Ask for the state of the film; begin to make it if a language is given.
  async #ask(language) {
    const flight = this.#flight;
    const request = { flight, ...(language && { language }) };
    try {
      const answer = await messages.film(this.station.bridge, request);
      if (flight !== this.#flight) return;
      if (answer.success) this.show(answer);
      else write(this.trouble, answer.message);
    } catch {
      /* the banner reports a lost connection */
    }
  }
}
