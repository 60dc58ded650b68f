// The table of all parts of a scenario. The arrow keys move through it.
import { all, el, fixed } from '../dom.js';
import { html, render } from '../vendor/preact.js';
import { placeOf } from './geometry.js';
import { sectionName } from './parts.js';

export class PartTable {
  #pick;
  #fieldsOf;

  // pick(index): called when a part is chosen. fieldsOf(part): the fields of its kind.
  constructor(pick, fieldsOf) {
    [this.#pick, this.#fieldsOf] = [pick, fieldsOf];
    this.element = el('div', { className: 'editor-table', onkeydown: (event) => this.#key(event) });
  }

  show(parts, selected) {
    const hadFocus = this.element.contains(document.activeElement);
    const row = (part, k) => html`
      ${
        part.section !== parts[k - 1]?.section &&
        html`<tr class="editor-section"><th colspan="3" scope="rowgroup">${sectionName(part.section)}</th></tr>`
      }
      <tr class=${k === selected ? 'is-selected' : ''}>
        <td>
          <button type="button" aria-pressed=${k === selected} tabindex=${k === Math.max(selected, 0) ? 0 : -1}
            onClick=${() => this.#pick(k)}>${part.name}</button>
        </td>
        <td class=${part.is_inherited ? 'is-inherited' : ''}>${part.is_inherited ? 'default' : part.kind}</td>
        <td>${(placeOf(part, this.#fieldsOf(part)) ?? []).map((value) => fixed(value, 1)).join(', ')}</td>
      </tr>
    `;
    const table = html`
      <table>
        <caption class="visually-hidden">All parts</caption>
        <thead><tr>${['Part', 'Kind', 'x, y [m]'].map((head) => html`<th scope="col">${head}</th>`)}</tr></thead>
        <tbody>${parts.map(row)}</tbody>
      </table>
    `;
    render(table, this.element);
    const current = this.#buttons()[selected];
    current?.scrollIntoView({ block: 'nearest' });
    if (hadFocus) current?.focus();
  }

  #buttons() {
    return [...all(this.element, 'button')];
  }

  #key(event) {
    const way = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const buttons = this.#buttons();
    const at = buttons.findIndex((button) => button === document.activeElement);
    if (!way || at < 0) return;
    event.preventDefault();
    const next = Math.min(Math.max(at + way, 0), buttons.length - 1);
    this.#pick(next);
    this.#buttons()[next]?.focus();
  }
}
