// The editor's tools: what to add, the brush, undo and redo, and where the scenario goes.
import { capital } from '../dom.js';
import { html } from '../vendor/preact.js';
import { WAYS } from './brush.js';

const button = (text, act, title = '', more = {}) =>
  html`<button type="button" title=${title} onClick=${act} ...${more}>${text}</button>`;

/** @param {import('./editor.js').SceneEditor} editor */
export function bar(editor) {
  const { acts, brush, chosen, part } = editor;
  const { can_undo, can_redo, is_saved, is_of_running } = editor.state ?? {};
  const vehicles = editor.state?.vehicles ?? [];
  const found = editor.offered.find(({ name }) => name === chosen.section);
  const kinds = found?.kinds.map(({ kind }) => kind).filter(Boolean) ?? [];
  const isNotGoal = { hidden: part?.section !== 'goals' };
  return html`
    ${choice(
      'What to add',
      chosen.section,
      editor.offered.map(({ name, title }) => [name, title]),
      (section) => editor.choose({ section }),
    )}
    ${choice('Kind', chosen.kind, twice(kinds), (kind) => editor.choose({ kind }), { hidden: !kinds.length })}
    ${choice('Vehicle', chosen.vehicle, Object.entries(vehicles), (vehicle) => editor.choose({ vehicle }), {
      hidden: !found?.of_vehicle || vehicles.length < 2,
    })}
    ${editor.asked.map((field) => file(editor, field))}
    ${button('Add', acts.add)}
    ${button('Delete', acts.remove, 'Delete, on the chart', { disabled: !editor.isRemovable })}
    ${button('Earlier', acts.earlier, ', on the chart: the chosen goal changes places with the one before', isNotGoal)}
    ${button('Later', acts.later, '. on the chart: the chosen goal changes places with the one after', isNotGoal)}
    ${button('Undo', acts.undo, 'Ctrl Z', { disabled: !can_undo })}
    ${button('Redo', acts.redo, 'Ctrl Y', { disabled: !can_redo })}
    ${button('Revert', acts.revert, 'Back to the file as opened or saved; can be undone', { disabled: is_saved })}
    ${button('3D view', acts.turn, 'V', { 'aria-pressed': editor.view !== editor.chart })}
    ${button('Fit', acts.fit)}
    <span class="editor-brush">
      ${choice('Brush', brush.way, [['', 'Brush'], ...twice(WAYS.slice(1), capital)], (way) => brush.take({ way }), {
        title: 'B: the next brush; [ and ]: narrower, wider. Drag on the chart to draw on the bed',
      })}
      ${number('Width of the brush [m]', brush.width_m, !brush.isOn, (width_m) => brush.take({ width_m }))}
      ${number('Height of a stroke [m]', brush.height_m, !brush.isOn || brush.way === 'smooth', (height_m) =>
        brush.take({ height_m }),
      )}
    </span>
    <span class="spring" />
    <label>Save as<input type="text" class="editor-name" autocomplete="off" spellcheck="false" maxlength="40" /></label>
    ${button('Save', acts.save, 'Ctrl S', { class: 'primary' })}
    ${button('Rebuild the world', acts.apply, '', { hidden: !is_of_running })}
  `;
}

const twice = (values, text = (value) => value) => values.map((value) => [value, text(value)]);

const choice = (label, value, texts, choose, more = {}) => html`
  <select aria-label=${label} value=${value} onInput=${({ target }) => choose(target.value)} ...${more}>
    ${texts.map(([each, text]) => html`<option value=${each}>${text}</option>`)}
  </select>
`;

const number = (name, value, hidden, set) => html`
  <input type="number" min="0.1" max="1000" step="any" value=${value} aria-label=${name} title=${name} hidden=${hidden}
    onInput=${({ target }) => set(Number(target.value))} />
`;

// The file that a part needs of which none is packaged.
const file = (editor, { name, meaning }) => html`
  <input type="text" autocomplete="off" spellcheck="false" key=${name} aria-label=${capital(name)} title=${meaning}
    placeholder=${name}
    onInput=${({ target }) => editor.choose({ values: { [name]: target.value.trim() } })} />
`;
