// The form of a part, with an input for each field of its kind, as its schema has it.
import { html } from '../vendor/preact.js';

const ROWS_MAX = 100; // of a table; longer ones are edited in the file

const plain = { type: 'text', autocomplete: 'off', spellcheck: false };
const shown = (value) =>
  value === null || value === undefined ? '' : typeof value === 'object' ? JSON.stringify(value) : String(value);

// Text that is no number is sent as it is: the server refuses it, with the reason.
const numeric = (text) => (text.trim() === '' || Number.isNaN(Number(text)) ? text : Number(text));

// The text that an input had from a state of the scenario. It has another one with the next: what is typed meanwhile
// stays, also what was refused.
const marks = new WeakMap();
const keep = (edition, text) => (input) => {
  const mark = `${edition} ${text}`;
  if (!input || marks.get(input) === mark) return;
  marks.set(input, mark);
  input.defaultValue = input.value = text;
};

/** @param {import('./editor.js').SceneEditor} editor */
export function form(editor) {
  const part = editor.parts.at(editor.selected);
  if (!part) return html`<p class="hint">Choose a part on the chart or in the table.</p>`;
  const edition = editor.state?.edition;
  return html`
    <div key=${JSON.stringify(part.place)}>
      <h3>${editor.parts.titleOf(part.section)}: ${part.name}</h3>
      ${
        part.is_inherited &&
        html`
          <p class="hint">
            By default: from the vehicle's own file, or at the station. A change is written into the scenario.
          </p>
        `
      }
      ${editor.parts.fieldsOf(part).map((field) => fieldset(editor, part, field, (value) => keep(edition, shown(value))))}
    </div>
  `;
}

// A text that was sent is a value, no text of the input's own; see keys.js.
export function settle({ target }) {
  target.defaultValue = target.value;
}

function fieldset(editor, part, field, own) {
  const { name, unit, meaning, type, width, role } = field;
  const choices = part.choices[name] ?? (type === 'flag' ? [true, false] : type === 'choice' ? field.choices : null);
  const given = part.values[name];
  const send = (value) => editor.set({ [name]: value });
  const refuse = (error) => editor.refuse(name, error.message);
  const wrong = editor.wrong.value.name === name ? editor.wrong.value.text : '';
  const make = type === 'table' ? rows : choices ? choice : type === 'number' && width > 1 ? numbers : single;
  return html`
    <fieldset class="editor-field" title=${meaning} data-field=${name} data-wrong=${wrong ? '' : null} key=${name}>
      <legend>${name}${unit && html`<span class="unit"> ${unit}</span>`}</legend>
      <div class="editor-inputs">${make({ ...field, choices: choices ?? field.choices }, given, send, own)}</div>
      <p class="wrong" role="alert">${wrong}</p>
      ${role === 'mesh' && editor.meshes.list(given, send, refuse)}
    </fieldset>
  `;
}

function single({ name, type, choices, by_default }, given, send, own) {
  const change = ({ target: { value } }) =>
    send(value.trim() === '' ? null : type === 'number' ? numeric(value) : value);
  const list = choices.length ? `choices-${name}` : null;
  return html`
    <input ...${plain} ref=${own(given)} placeholder=${shown(by_default)} aria-label=${name} list=${list}
      onChange=${change} />
    ${list && html`<datalist id=${list}>${choices.map((each) => html`<option value=${each} />`)}</datalist>`}
  `;
}

function numbers({ name, width, by_default }, given, send, own) {
  const change = ({ target }) => {
    const inputs = /** @type {HTMLInputElement[]} */ ([...target.parentElement.children]);
    const isEmpty = inputs.every(({ value }) => value.trim() === '');
    send(isEmpty ? null : inputs.map(({ value, placeholder }) => numeric(value.trim() === '' ? placeholder : value)));
  };
  return Array.from(
    { length: width },
    (_, k) => html`
      <input ...${plain} ref=${own(given?.[k])} placeholder=${shown(by_default?.[k])} aria-label="${name} ${k + 1}"
        onChange=${change} />
    `,
  );
}

function choice({ name, choices, by_default, is_required }, given, send, own) {
  const usual = by_default === null ? '–' : `default: ${shown(by_default)}`;
  const change = ({ target }) => send(choices.find((value) => String(value) === target.value) ?? null);
  return html`
    <select aria-label=${name} ref=${own(given)} onChange=${change}>
      ${!is_required && html`<option value="">${usual}</option>`}
      ${choices.map((value) => html`<option value=${String(value)}>${String(value)}</option>`)}
    </select>
  `;
}

function rows({ name, columns, by_default }, given, send, own) {
  const list = Array.isArray(given) ? given : [];
  if (list.length > ROWS_MAX) return html`<p class="hint">${list.length} rows: edit them in the file</p>`;
  const titles = columns.map((column) =>
    column.replace(/^(.*?)(_m|_m_s|_deg)?\[(\d)\]$/, (_, word, __, k) => `${word.split('_')[0]} ${'xyz'[k] ?? k}`),
  );
  const changed = (k, j, value) => send(list.map((row, i) => (i === k ? row.with(j, numeric(value)) : row)));
  const cell = (row, k, j) => html`
    <td>
      <input ...${plain} ref=${own(row[j])} aria-label="${name} ${k + 1}: ${titles[j]}"
        onChange=${({ target }) => changed(k, j, target.value)} />
    </td>
  `;
  const line = (row, k) => html`
    <tr>
      ${columns.map((_, j) => cell(row, k, j))}
      <td>
        <button type="button" aria-label="Remove row ${k + 1}" onClick=${() => send(list.toSpliced(k, 1))}>✕</button>
      </td>
    </tr>
  `;
  const next = () =>
    list.at(-1)?.map((value, j) => (j === 0 ? value + 1 : value)) ?? by_default.map((value) => value ?? 0);
  return html`
    <div class="editor-rows">
      <table>
        <thead><tr>${titles.map((title) => html`<th scope="col">${title}</th>`)}<td /></tr></thead>
        <tbody>${list.map(line)}</tbody>
      </table>
      <button type="button" onClick=${() => send([...list, next()])}>Add a row</button>
    </div>
  `;
}
