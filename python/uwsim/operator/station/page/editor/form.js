// The form of a part, with an input for each field of its kind.
import { all, el, first } from '../dom.js';
import { html, render } from '../vendor/preact.js';
import { sectionName } from './parts.js';

const ROWS_MAX = 100; // of a table; longer ones are edited in the file

const plain = { type: 'text', autocomplete: 'off', spellcheck: false };
const shown = (value) =>
  value === null || value === undefined ? '' : typeof value === 'object' ? JSON.stringify(value) : String(value);

// Text that is no number is sent as it is: the server refuses it, with the reason.
const numeric = (text) => (text.trim() === '' || Number.isNaN(Number(text)) ? text : Number(text));

// A text that was sent is a value, no text of the input's own; see keys.js.
function sent({ target }) {
  target.defaultValue = target.value;
}

export class PartForm {
  #set;
  #meshes;

  // set(values): called with the field that was changed; null for one that is to have its default again. meshes: the
  // EditorMeshes.
  constructor(set, meshes) {
    [this.#set, this.#meshes] = [set, meshes];
    this.element = el('div', { className: 'editor-form', onchange: sent });
  }

  /** @param {any} part
   * @param {import('../wire/messages.js').FormField[]} fields
   */
  show(part, fields) {
    const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset?.at;
    const scroll = this.element.scrollTop;
    this.element.replaceChildren(
      ...(part
        ? [
            el('h3', {}, `${sectionName(part.section)}: ${part.name}`),
            part.is_inherited
              ? el(
                  'p',
                  { className: 'hint' },
                  "By default: from the vehicle's own file, or at the station. A change is written into the scenario.",
                )
              : '',
            ...fields.map((field) => this.#field(part, field)),
          ]
        : [el('p', { className: 'hint' }, 'Choose a part on the chart or in the table.')]),
    );
    this.element.scrollTop = scroll;
    if (focused) [...all(this.element, '[data-at]')].find((each) => each.dataset.at === focused)?.focus();
  }

  // Show why a field was refused; '' for none.
  refuse(name, text) {
    for (const box of all(this.element, '[data-field]')) {
      const isIt = box.dataset.field === name && text !== '';
      box.toggleAttribute('data-wrong', isIt);
      first(box, '.wrong').textContent = isIt ? text : '';
    }
  }

  // Show values that are being changed on the chart.
  update(values) {
    for (const [name, value] of Object.entries(values))
      [value].flat(2).forEach((each, k) => {
        const input = /** @type {HTMLInputElement | undefined} */ (
          [...all(this.element, '[data-at]')].find(({ dataset }) => dataset.at === `${name} ${k}`)
        );
        if (input) input.value = shown(each);
      });
  }

  #field(part, field) {
    const { name, unit, meaning, type, width, role } = field;
    const choices = part.choices[name];
    const given = part.values[name];
    const send = (value) => this.#set({ [name]: value });
    const inputs =
      type === 'table'
        ? [this.#table(field, Array.isArray(given) ? given : [], send)]
        : type === 'flag' || type === 'choice' || choices
          ? [this.#choice(choices ? { ...field, choices } : field, given, send)]
          : type === 'number' && width > 1
            ? this.#numbers(field, given, send)
            : [this.#text(field, given, send)];
    return el(
      'fieldset',
      { className: 'editor-field', title: meaning, 'data-field': name },
      el('legend', {}, name, unit ? el('span', { className: 'unit' }, ` ${unit}`) : null),
      el('div', { className: 'editor-inputs' }, ...inputs),
      el('p', { className: 'wrong', role: 'alert' }),
      ...(role === 'mesh' ? this.#meshes.list(given, send, (error) => this.refuse(name, error.message)) : []),
    );
  }

  #text(field, given, send) {
    const isNumber = field.type === 'number';
    return el('input', {
      ...plain,
      defaultValue: shown(given),
      placeholder: shown(field.by_default),
      'aria-label': field.name,
      'data-at': `${field.name} 0`,
      onchange: ({ target }) =>
        send(target.value.trim() === '' ? null : isNumber ? numeric(target.value) : target.value),
    });
  }

  #numbers(field, given, send) {
    const inputs = Array.from({ length: field.width }, (_, k) =>
      el('input', {
        ...plain,
        defaultValue: shown(given?.[k]),
        placeholder: shown(field.by_default?.[k]),
        'aria-label': `${field.name} ${k + 1}`,
        'data-at': `${field.name} ${k}`,
        onchange: () => {
          const texts = inputs.map(({ value }) => value);
          if (texts.every((text) => text.trim() === '')) send(null);
          else send(inputs.map(({ value, placeholder }) => numeric(value.trim() === '' ? placeholder : value)));
        },
      }),
    );
    return inputs;
  }

  #choice(field, given, send) {
    const choices = field.type === 'flag' ? [true, false] : field.choices;
    const usual = field.by_default === null ? '–' : `default: ${shown(field.by_default)}`;
    const select = el(
      'select',
      {
        'aria-label': field.name,
        'data-at': `${field.name} 0`,
        onchange: () => send(choices.find((value) => String(value) === select.value) ?? null),
      },
      field.is_required ? null : el('option', { value: '' }, usual),
      ...choices.map((value) => el('option', { value: String(value) }, String(value))),
    );
    select.value = shown(given);
    return select;
  }

  #table(field, rows, send) {
    const { name, columns, by_default: usual } = field;
    if (rows.length > ROWS_MAX) return el('p', { className: 'hint' }, `${rows.length} rows: edit them in the file`);
    const titles = columns.map((column) =>
      column.replace(/^(.*?)(_m|_m_s|_deg)?\[(\d)\]$/, (_, word, __, k) => `${word.split('_')[0]} ${'xyz'[k] ?? k}`),
    );
    const changed = (k, j, text) => send(rows.map((row, i) => (i === k ? row.with(j, numeric(text)) : row)));
    const cell = (row, k, j) => html`
      <td>
        <input ...${plain} defaultValue=${shown(row[j])} aria-label="${name} ${k + 1}: ${titles[j]}"
          data-at="${name} ${k * columns.length + j}" onChange=${({ target }) => changed(k, j, target.value)} />
      </td>
    `;
    const line = (row, k) => html`
      <tr>
        ${columns.map((_, j) => cell(row, k, j))}
        <td>
          <button type="button" aria-label="Remove row ${k + 1}" onClick=${() => send(rows.toSpliced(k, 1))}>✕</button>
        </td>
      </tr>
    `;
    const next = () =>
      rows.length
        ? rows[rows.length - 1].map((value, j) => (j === 0 ? value + 1 : value))
        : usual.map((value) => value ?? 0);
    const table = html`
      <table>
        <thead><tr>${titles.map((title) => html`<th scope="col">${title}</th>`)}<td /></tr></thead>
        <tbody>${rows.map(line)}</tbody>
      </table>
      <button type="button" data-at="${name} add" onClick=${() => send([...rows, next()])}>Add a row</button>
    `;
    const box = el('div', { className: 'editor-rows' });
    render(table, box);
    return box;
  }
}
