// The table of all parts of a scenario. The arrow keys move through it.
import { all, fixed } from '../dom.js';
import { html } from '../vendor/preact.js';
import { placeOf } from './geometry.js';

const reveal = (button) => void button?.scrollIntoView({ block: 'nearest' });

/** @param {import('./editor.js').SceneEditor} editor */
export function table(editor) {
  const { parts, selected } = editor;
  const row = (part, k) => html`
    ${
      part.section !== parts.list[k - 1]?.section &&
      html`<tr class="editor-section"><th colspan="3" scope="rowgroup">${editor.parts.titleOf(part.section)}</th></tr>`
    }
    <tr class=${k === selected ? 'is-selected' : ''}>
      <td>
        <button type="button" aria-pressed=${k === selected} tabindex=${k === Math.max(selected, 0) ? 0 : -1}
          ref=${k === selected ? reveal : null} onClick=${() => editor.pick(k)}>${part.name}</button>
      </td>
      <td class=${part.is_inherited ? 'is-inherited' : ''}>${part.is_inherited ? 'default' : part.kind}</td>
      <td>${(placeOf(part, editor.parts.fieldsOf(part)) ?? []).map((value) => fixed(value, 1)).join(', ')}</td>
    </tr>
  `;
  return html`
    <table>
      <caption class="visually-hidden">All parts</caption>
      <thead><tr>${['Part', 'Kind', 'x, y [m]'].map((head) => html`<th scope="col">${head}</th>`)}</tr></thead>
      <tbody>${parts.list.map(row)}</tbody>
    </table>
  `;
}

export function tableKey(event, editor) {
  const way = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  const buttons = [...all(event.currentTarget, 'button')];
  const at = buttons.findIndex((button) => button === document.activeElement);
  if (!way || at < 0) return;
  event.preventDefault();
  const next = Math.min(Math.max(at + way, 0), buttons.length - 1);
  editor.pick(next);
  buttons[next].focus();
}
