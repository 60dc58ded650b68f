// The table of all parts of a scenario. The arrow keys move through it.
import { all, el, fixed } from '../dom.js';
import { placeOf } from './geometry.js';
import { sectionName } from './parts.js';

export class PartTable {
  #pick;
  #fieldsOf;

  // pick(index): called when a part is chosen. fieldsOf(part): the fields of its kind.
  constructor(pick, fieldsOf) {
    [this.#pick, this.#fieldsOf] = [pick, fieldsOf];
    this.body = el('tbody');
    const heads = ['Part', 'Kind', 'x, y [m]'].map((text) => el('th', { scope: 'col' }, text));
    const caption = el('caption', { className: 'visually-hidden' }, 'All parts');
    this.element = el(
      'div',
      { className: 'editor-table', onkeydown: (event) => this.#key(event) },
      el('table', {}, caption, el('thead', {}, el('tr', {}, ...heads)), this.body),
    );
  }

  show(parts, selected) {
    const hadFocus = this.body.contains(document.activeElement);
    let section = '';
    const rows = parts.flatMap((part, k) => {
      const isNew = part.section !== section;
      section = part.section;
      const title = sectionName(section);
      const head = el('tr', { className: 'editor-section' }, el('th', { colSpan: 3, scope: 'rowgroup' }, title));
      return [...(isNew ? [head] : []), this.#row(part, k, selected)];
    });
    this.body.replaceChildren(...rows);
    const current = this.#buttons()[selected];
    current?.scrollIntoView({ block: 'nearest' });
    if (hadFocus) current?.focus();
  }

  #row(part, index, selected) {
    const place = placeOf(part, this.#fieldsOf(part));
    const isSelected = index === selected;
    const button = el(
      'button',
      {
        type: 'button',
        'aria-pressed': String(isSelected),
        tabIndex: isSelected || (selected < 0 && index === 0) ? 0 : -1,
        onclick: () => this.#pick(index),
      },
      part.name,
    );
    return el(
      'tr',
      { className: isSelected ? 'is-selected' : '' },
      el('td', {}, button),
      el('td', { className: part.is_inherited ? 'is-inherited' : '' }, part.is_inherited ? 'default' : part.kind),
      el('td', {}, place ? place.map((value) => fixed(value, 1)).join(', ') : ''),
    );
  }

  #buttons() {
    return [...all(this.body, 'button')];
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
