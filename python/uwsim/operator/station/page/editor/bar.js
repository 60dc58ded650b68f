// The editor's tools: what to add, undo and redo, and where the scenario goes.
import { el } from '../dom.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.editor;
const button = (text, act, more = {}) => el('button', { type: 'button', onclick: act, ...more }, text);

export class EditorBar {
  sections = []; // as in EditForms

  /** @param {import('./brush.js').Brush} brush
   * @param {Record<'add' | 'remove' | 'earlier' | 'later' | 'undo' | 'redo' | 'revert' | 'turn' | 'fit' | 'save' | 'apply', () => void>} acts
   */
  constructor(brush, acts) {
    this.section = el('select', { 'aria-label': WORDS.section, onchange: () => this.#showKinds() });
    this.kind = el('select', { 'aria-label': WORDS.kind });
    this.vehicle = el('select', { 'aria-label': WORDS.vehicle });
    this.remove = button(WORDS.remove, acts.remove, { tip: WORDS.removeKey });
    this.earlier = button(WORDS.earlier, acts.earlier, { tip: WORDS.earlierKey });
    this.later = button(WORDS.later, acts.later, { tip: WORDS.laterKey });
    this.undo = button(WORDS.undo, acts.undo, { tip: WORDS.undoKey });
    this.redo = button(WORDS.redo, acts.redo, { tip: WORDS.redoKey });
    this.revert = button(WORDS.revert, acts.revert, { tip: WORDS.revertTip });
    this.turn = button(WORDS.inThree, acts.turn, { tip: WORDS.inThreeKey, 'aria-pressed': 'false' });
    this.name = el('input', { type: 'text', autocomplete: 'off', spellcheck: false, maxLength: 40 });
    this.apply = button(WORDS.apply, acts.apply);
    this.element = el(
      'div',
      { className: 'editor-bar', role: 'toolbar', 'aria-label': WORDS.tools },
      this.section,
      this.kind,
      this.vehicle,
      button(WORDS.add, acts.add),
      this.remove,
      this.earlier,
      this.later,
      this.undo,
      this.redo,
      this.revert,
      this.turn,
      button(WORDS.fit, acts.fit),
      brush.element,
      el('span', { className: 'spring' }),
      el('label', {}, WORDS.name, this.name),
      button(WORDS.save, acts.save, { className: 'primary', tip: WORDS.saveKey }),
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
    fill(
      this.section,
      offered.map(({ name }) => [name, WORDS.sections[name] ?? name]),
    );
    fill(
      this.vehicle,
      (vehicles ?? []).map((name, k) => [String(k), name]),
    );
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
    fill(
      this.kind,
      kinds.map((each) => [each, each]),
    );
    this.kind.hidden = !kinds.length;
    this.vehicle.hidden = !found?.of_vehicle || this.vehicle.options.length < 2;
  }
}

// Fill a select with values and texts; its choice stays if it is still offered.
function fill(select, pairs) {
  const chosen = select.value;
  select.replaceChildren(...pairs.map(([value, text]) => el('option', { value }, text)));
  if (pairs.some(([value]) => value === chosen)) select.value = chosen;
}
