// Inspection: the comment shown in pictures, and notes with category, picture and position.
import { attempt, capital, clockText, el, toast, write } from '../dom.js';
import { NOTE_CATEGORIES, notes as request } from '../wire/messages.js';

const PLACES = [
  ['view', "In camera's view"],
  ['vehicle', 'At the vehicle'],
];
const TEXT_MOST = 200;

const choice = (label, values) =>
  el('select', { 'aria-label': label, title: label }, ...values.map(([value, text]) => el('option', { value }, text)));
const line = (label, id) =>
  el('input', {
    type: 'text',
    id,
    'aria-label': label,
    placeholder: label,
    maxLength: TEXT_MOST,
    autocomplete: 'off',
    spellcheck: false,
  });

// Events: 'notes', when the notes have changed.
export class Inspection extends EventTarget {
  notes = []; // as the server lists them
  #vehicle = '';
  #shown = ''; // the run and the number of notes shown

  constructor(station, views) {
    super();
    this.station = station;
    this.views = views;
    this.comment = line('Comment in pictures', 'comment');
    this.text = line('Text of the note', 'note-text');
    this.category = choice(
      'Category of the note',
      NOTE_CATEGORIES.map((each) => [each, capital(each)]),
    );
    this.place = choice('Place of the note', PLACES);
    this.set = el('button', { type: 'submit' }, 'Set');
    this.button = el('button', { type: 'submit', id: 'add-note' }, 'Add note');
    this.list = el('ol', { className: 'notes', tabIndex: 0, 'aria-label': 'Notes, newest first' });
    this.links = el('div', { className: 'downloads', role: 'group', 'aria-label': 'Download the notes' });
    this.count = el('small');
    this.form = el(
      'form',
      { onsubmit: (event) => this.#submit(event, () => this.add()) },
      el('div', { className: 'row' }, this.category, this.place),
      el('div', { className: 'row' }, this.text, this.button),
    );
    this.element = el(
      'section',
      { id: 'inspection', className: 'inspection' },
      el('h2', {}, 'Inspection', this.count),
      el(
        'form',
        { className: 'row', onsubmit: (event) => this.#submit(event, () => this.#setComment()) },
        this.comment,
        this.set,
      ),
      this.form,
      this.list,
      this.links,
    );
    station.addEventListener('state', () => this.#look());
  }

  begin(vehicle) {
    this.#vehicle = vehicle.name;
    this.links.replaceChildren(
      ...['csv', 'geojson'].map((kind) =>
        el(
          'a',
          {
            href: this.station.href(`/notes/notes.${kind}`),
            download: `notes.${kind}`,
            'aria-label': `Notes as .${kind}`,
          },
          `.${kind}`,
        ),
      ),
    );
    this.#shown = '';
    this.#look();
  }

  // Focus the field so that the pilot can type.
  focus() {
    this.comment.focus();
    this.comment.select();
  }

  // Write a note with the form's text, and a picture if the large view is a camera's.
  async add() {
    const { largeView } = this.views;
    const answer = await attempt(
      request(this.station.bridge, {
        action: 'add',
        vehicle: this.#vehicle,
        text: this.text.value,
        category: this.category.value,
        place: this.place.value,
        view: largeView?.isCamera ? this.views.large : '',
      }),
    );
    if (!answer) return;
    this.text.value = '';
    this.#show(answer);
    toast(answer.message);
  }

  async #setComment() {
    const { value: text } = this.comment;
    const answer = await attempt(
      request(this.station.bridge, { action: 'comment', vehicle: this.#vehicle, text }),
      'The comment is now shown in pictures',
    );
    if (answer) this.#show(answer);
  }

  #submit(event, act) {
    event.preventDefault();
    /** @type {HTMLElement | null} */ (document.activeElement)?.blur(); // the keys drive again
    act();
  }

  // Follow the state: the comment and the number of notes.
  async #look() {
    const { state, isPilot, isRunning } = this.station;
    const { comment = '' } = state;
    if (document.activeElement !== this.comment && this.comment.value !== comment) this.comment.value = comment;
    for (const part of [this.text, this.category, this.place, this.button]) part.disabled = !isPilot;
    this.comment.disabled = this.set.disabled = !isPilot;
    const wanted = `${state.session} ${state.notes}`;
    if (!isRunning || state.notes === undefined || wanted === this.#shown) return;
    this.#shown = wanted;
    try {
      this.#show(await request(this.station.bridge, { action: 'list' }));
    } catch {
      this.#shown = ''; // the banner reports a lost connection
    }
  }

  /** @param {import('../wire/messages.js').NotesState | import('../wire/messages.js').Refused} answer */
  #show(answer) {
    if (!answer.success) return;
    const { notes } = answer;
    this.notes = notes;
    write(this.count, notes.length ? String(notes.length) : '');
    this.list.replaceChildren(
      ...notes.toReversed().map(({ number, time_s, category, text, picture }) => {
        const said = `${number}. ${capital(category)}${text ? `: ${text}` : ''} `;
        const link = picture
          ? el('a', { href: this.station.href(`/notes/${picture}`), target: '_blank', rel: 'noopener' }, 'picture')
          : null;
        return el('li', {}, el('time', {}, clockText(time_s)), ` ${said}`, link);
      }),
    );
    this.dispatchEvent(new Event('notes'));
  }
}
