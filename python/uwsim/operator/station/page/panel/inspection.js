// Inspection: the comment shown in pictures, and notes with category, picture and position.
import { attempt, byId, capital, clockText, toast } from '../dom.js';
import { html, signal } from '../vendor/preact.js';
import { NOTE_CATEGORIES, notes as request } from '../wire/messages.js';
import { downloads } from './rows.js';

const PLACES = [
  ['view', "In camera's view"],
  ['vehicle', 'At the vehicle'],
];
const TEXT_MOST = 200;

const choice = (name, label, values, mayNot) => html`
  <select name=${name} aria-label=${label} title=${label} disabled=${mayNot}>
    ${values.map(([value, text]) => html`<option value=${value}>${text}</option>`)}
  </select>
`;

// Events: 'notes', when the notes have changed.
export class Inspection extends EventTarget {
  #notes = signal([]); // as the server lists them
  #vehicle = '';
  #listed = ''; // the run and the number of notes shown

  constructor(station, views) {
    super();
    this.station = station;
    this.views = views;
    station.addEventListener('state', () => this.#look());
  }

  get notes() {
    return this.#notes.value;
  }

  begin(vehicle) {
    this.#vehicle = vehicle.name;
    this.#listed = '';
    this.#look();
  }

  // Focus the field so that the pilot can type.
  focus() {
    byId('comment').focus();
    /** @type {any} */ (byId('comment')).select();
  }

  // Write a note with the form's text, and a picture if the large view is a camera's.
  async add() {
    const { large, largeView } = this.views;
    const { text, category, place } = /** @type {any} */ (byId('note').elements);
    const answer = await attempt(
      request(this.station.bridge, {
        action: 'add',
        vehicle: this.#vehicle,
        text: text.value,
        category: category.value,
        place: place.value,
        view: largeView?.isCamera ? large : '',
      }),
    );
    if (!answer) return;
    text.value = '';
    this.#show(answer);
    toast(answer.message);
  }

  async #setComment() {
    const answer = await attempt(
      request(this.station.bridge, { action: 'comment', vehicle: this.#vehicle, text: byId('comment').value }),
      'The comment is now shown in pictures',
    );
    if (answer) this.#show(answer);
  }

  #submit(event, act) {
    event.preventDefault();
    /** @type {HTMLElement | null} */ (document.activeElement)?.blur(); // the keys drive again
    act();
  }

  // Follow the number of notes.
  async #look() {
    const { state, isRunning } = this.station;
    const wanted = `${state.session} ${state.notes}`;
    if (!isRunning || state.notes === undefined || wanted === this.#listed) return;
    this.#listed = wanted;
    try {
      this.#show(await request(this.station.bridge, { action: 'list' }));
    } catch {
      this.#listed = ''; // the banner reports a lost connection
    }
  }

  /** @param {import('../wire/messages.js').NotesState | import('../wire/messages.js').Refused} answer */
  #show(answer) {
    if (!answer.success) return;
    this.#notes.value = answer.notes;
    this.dispatchEvent(new Event('notes'));
  }

  #note({ number, time_s, category, text, picture }) {
    const link = html`<a href=${this.station.href(`/notes/${picture}`)} target="_blank" rel="noopener">picture</a>`;
    const said = `${number}. ${capital(category)}${text ? `: ${text}` : ''}`;
    return html`<li key=${number}><time>${clockText(time_s)}</time> ${said} ${picture && link}</li>`;
  }

  view() {
    const { state, isPilot } = this.station;
    const mayNot = !isPilot;
    const line = (id, name, label, value) => html`
      <input type="text" id=${id} name=${name} aria-label=${label} placeholder=${label} maxlength=${TEXT_MOST}
        autocomplete="off" spellcheck="false" value=${value} disabled=${mayNot} />
    `;
    const comment = document.activeElement?.id === 'comment' ? undefined : (state.comment ?? '');
    return html`
      <section id="inspection" class="inspection">
        <h2>Inspection<small>${this.notes.length || ''}</small></h2>
        <form class="row" onSubmit=${(event) => this.#submit(event, () => this.#setComment())}>
          ${line('comment', 'comment', 'Comment in pictures', comment)}
          <button type="submit" disabled=${mayNot}>Set</button>
        </form>
        <form id="note" onSubmit=${(event) => this.#submit(event, () => this.add())}>
          <div class="row">
            ${choice(
              'category',
              'Category of the note',
              NOTE_CATEGORIES.map((each) => [each, capital(each)]),
              mayNot,
            )}
            ${choice('place', 'Place of the note', PLACES, mayNot)}
          </div>
          <div class="row">
            ${line('note-text', 'text', 'Text of the note')}
            <button type="submit" id="add-note" disabled=${mayNot}>Add note</button>
          </div>
        </form>
        <ol class="notes" tabindex="0" aria-label="Notes, newest first">
          ${this.notes.toReversed().map((note) => this.#note(note))}
        </ol>
        ${downloads('Download the notes', ['csv', 'geojson'], (kind) => ({
          href: this.station.href(`/notes/notes.${kind}`),
          download: `notes.${kind}`,
          'aria-label': `Notes as .${kind}`,
        }))}
      </section>
    `;
  }
}
