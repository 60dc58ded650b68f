// The editor's tools: what to add, undo and redo, and where the scenario goes.
import { el } from '../dom.js';
import { sectionName } from './parts.js';

const button = (text, act, more = {}) => el('button', { type: 'button', onclick: act, ...more }, text);

export class EditorBar {
  sections = []; // as in EditForms

  /** @param {import('./brush.js').Brush} brush
   * @param {Record<'add' | 'remove' | 'earlier' | 'later' | 'undo' | 'redo' | 'revert' | 'turn' | 'fit' | 'save' | 'apply', () => void>} acts
   */
  constructor(brush, acts) {
    this.section = el('select', { 'aria-label': 'What to add', onchange: () => this.#showKinds() });
    this.kind = el('select', { 'aria-label': 'Kind' });
    this.vehicle = el('select', { 'aria-label': 'Vehicle' });
    this.remove = button('Delete', acts.remove, { title: 'Delete, on the chart' });
    this.earlier = button('Earlier', acts.earlier, {
      title: ', on the chart: the chosen goal changes places with the one before',
    });
    this.later = button('Later', acts.later, {
      title: '. on the chart: the chosen goal changes places with the one after',
    });
    this.undo = button('Undo', acts.undo, { title: 'Ctrl Z' });
    this.redo = button('Redo', acts.redo, { title: 'Ctrl Y' });
    this.revert = button('Revert', acts.revert, { title: 'Back to the file as opened or saved; can be undone' });
    this.turn = button('3D view', acts.turn, { title: 'V', 'aria-pressed': 'false' });
    this.name = el('input', { type: 'text', autocomplete: 'off', spellcheck: false, maxLength: 40 });
    this.apply = button('Rebuild the world', acts.apply);
    this.element = el(
      'div',
      { className: 'editor-bar', role: 'toolbar', 'aria-label': 'Tools of the editor' },
      this.section,
      this.kind,
      this.vehicle,
      button('Add', acts.add),
      this.remove,
      this.earlier,
      this.later,
      this.undo,
      this.redo,
      this.revert,
      this.turn,
      button('Fit', acts.fit),
      brush.element,
      el('span', { className: 'spring' }),
      el('label', {}, 'Save as', this.name),
      button('Save', acts.save, { className: 'primary', title: 'Ctrl S' }),
      this.apply,
    );
  }

  // What the person has chosen to add.
  get chosen() {
    return { section: this.section.value, kind: this.kind.value, vehicle: Number(this.vehicle.value) };
  }

  /** @param {import('../wire/messages.js').EditState} state */
  show({ vehicles, can_undo, can_redo, is_saved, is_of_running }) {
    this.revert.disabled = Boolean(is_saved);
    [this.undo.disabled, this.redo.disabled, this.apply.hidden] = [!can_undo, !can_redo, !is_of_running];
    const offered = this.sections.filter(({ name }) => name !== 'starts');
    fill(this.section, Object.fromEntries(offered.map(({ name }) => [name, sectionName(name)])));
    fill(this.vehicle, { ...vehicles });
    this.#showKinds();
  }

  // part: the chosen one, if any.
  showPart(part) {
    this.remove.disabled = !part || part.section === 'starts';
    this.earlier.hidden = this.later.hidden = part?.section !== 'goals';
  }

  // isScene: whether the 3D view is shown in place of the chart.
  showScene(isScene) {
    this.turn.setAttribute('aria-pressed', String(isScene));
  }

  #showKinds() {
    const found = this.sections.find(({ name }) => name === this.section.value);
    const kinds = found?.kinds.map((each) => each.kind).filter(Boolean) ?? [];
    fill(this.kind, Object.fromEntries(kinds.map((each) => [each, each])));
    this.kind.hidden = !kinds.length;
    this.vehicle.hidden = !found?.of_vehicle || this.vehicle.options.length < 2;
  }
}

// Fill a select with texts by value; its choice stays if it is still offered.
function fill(select, texts) {
  const chosen = select.value;
  select.replaceChildren(...Object.entries(texts).map(([value, text]) => el('option', { value }, text)));
  if (chosen in texts) select.value = chosen;
}
