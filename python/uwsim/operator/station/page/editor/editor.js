// The scene editor: a chart, a table and a form of one scenario, which the server holds, checks and writes.
import { openDialog } from '../dialogs/dialog.js';
import { byId, el, toast, write } from '../dom.js';
import { STRINGS } from '../strings.js';
import { edit, editForms } from '../wire/messages.js';
import { EditorBar } from './bar.js';
import { EditorChart } from './chart.js';
import { PartForm } from './form.js';
import { chartKey, editorKey } from './keys.js';
import { PartTable } from './table.js';

const WORDS = STRINGS.editor;
const SEND_MS = 250; // after the last key or notch of the wheel
const CHECK_MS = 800; // after the last change

/** @typedef {import('../wire/messages.js').EditState} EditState */

export class SceneEditor {
  /** @type {EditState | null} */
  state = null;
  selected = -1;
  savedName = ''; // under which it was saved since it was opened
  #timers = { send: 0, check: 0 };
  /** @type {Promise<any>} */
  #queue = Promise.resolve();
  #bed = '';
  /** @type {(name: string) => void} */
  #onClose = () => {};

  // load(path): fetches from the server.
  constructor(station, load) {
    this.station = station;
    this.load = load;
    const fieldsOf = (part) => this.fieldsOf(part);
    this.acts = {
      add: () => this.#add(),
      remove: () => this.#remove(),
      undo: () => this.#act({ action: 'undo' }),
      redo: () => this.#act({ action: 'redo' }),
      fit: () => this.chart.fit(),
      save: () => this.#save(),
      apply: () => this.#apply(),
    };
    this.bar = new EditorBar(this.acts);
    this.chart = new EditorChart(fieldsOf);
    this.form = new PartForm((values) => this.#set(values, true));
    this.table = new PartTable((index) => this.pick(index), fieldsOf);
    this.message = el('p', { className: 'editor-message', role: 'status' });
    this.source = el('pre', { className: 'editor-source', tabIndex: 0 });
    this.chart.addEventListener('pick', (event) => this.pick(/** @type {CustomEvent} */ (event).detail, true));
    this.chart.addEventListener('draft', (event) => this.form.update(/** @type {CustomEvent} */ (event).detail));
    this.chart.addEventListener('done', () => this.#sendLater());
    this.chart.canvas.addEventListener('keydown', (event) => chartKey(event, this, this.acts));
    this.element = el(
      'div',
      { className: 'editor', onkeydown: (event) => editorKey(event, this.acts) },
      this.bar.element,
      this.chart.canvas,
      el(
        'div',
        { className: 'editor-side' },
        this.table.element,
        this.form.element,
        el('details', {}, el('summary', {}, WORDS.source), this.source),
      ),
      el('footer', { className: 'editor-foot' }, this.message, el('p', { className: 'hint' }, WORDS.keys)),
    );
  }

  /** Open a scenario, '' for that of the running simulator; what was not saved yet is still there. onClose(name): called
   * with the name under which it was saved, or ''.
   * @param {string} scenario
   * @param {(name: string) => void} onClose
   */
  async open(scenario, onClose = () => {}) {
    const { bridge } = this.station;
    try {
      await this.#queue;
      if (!this.bar.sections.length) {
        const found = await editForms(bridge);
        if (!found.success) throw new Error(found.message);
        this.bar.sections = found.sections;
      }
      const kept = await edit(bridge, { action: 'report' });
      const isKept =
        this.state &&
        kept.success &&
        kept.by === this.station.name &&
        !kept.is_saved &&
        (scenario || kept.name) === kept.name;
      const isMine = isKept && kept.is_of_running === (scenario === '');
      const state = isMine ? kept : await edit(bridge, { action: 'open', ...(scenario ? { scenario } : {}) });
      if (!state.success) throw new Error(state.message);
      [this.selected, this.savedName, this.#onClose, this.#bed] = [-1, '', onClose, ''];
      const dialog = byId('editor-dialog');
      openDialog(dialog, WORDS.title(state.name), this.element);
      dialog.addEventListener('close', () => this.#left(), { once: true });
      this.bar.name.value = (state.name ?? '').replace(/\.ya?ml$/, '').replace(/.*\//, '');
      await this.#show(state);
      this.chart.canvas.focus();
    } catch (error) {
      toast(error.message, 'error');
    }
  }

  // Send what is left, and let others edit if nothing is unsaved.
  #left() {
    this.#flush();
    this.#queue = this.#queue.then(() => {
      this.#onClose(this.savedName);
      return this.state?.is_saved ? edit(this.station.bridge, { action: 'close' }).catch(() => null) : null;
    });
  }

  /** The fields of a part's kind.
   * @returns {import('../wire/messages.js').FormField[]}
   */
  fieldsOf({ section, kind }) {
    return (
      this.bar.sections.find(({ name }) => name === section)?.kinds.find((each) => each.kind === kind)?.fields ?? []
    );
  }

  get part() {
    return this.state?.parts?.[this.selected];
  }

  pick(index, isOnChart = false) {
    this.#flush();
    this.selected = index;
    this.#showParts();
    if (!isOnChart) this.chart.reveal();
    this.chart.draw();
  }

  async #show(state) {
    const isNew = state.text !== this.state?.text;
    this.state = state;
    const { grid, parts } = state;
    if (this.selected >= parts.length) this.selected = -1;
    this.bar.show(state);
    this.source.textContent = state.text;
    this.#showParts();
    const bed = JSON.stringify(grid);
    if (bed !== this.#bed) {
      this.#bed = bed;
      this.chart.showBed(new Float32Array(await (await this.load('/edit/terrain.f32')).arrayBuffer()), grid);
    }
    if (isNew) {
      clearTimeout(this.#timers.check);
      this.#timers.check = setTimeout(() => this.#check(), CHECK_MS);
    }
  }

  #showParts() {
    const parts = this.state?.parts ?? [];
    this.chart.show(parts, this.selected);
    this.table.show(parts, this.selected);
    this.form.show(this.part, this.part ? this.fieldsOf(this.part) : []);
    this.bar.remove.disabled = !this.part || this.part.section === 'starts';
  }

  // Send a request after those before it, and show the answer or the refusal. Return the answer, null after a refusal.
  #act(request, field = '', isOfForm = false) {
    const sent = this.#queue.then(async () => {
      try {
        const state = await edit(this.station.bridge, request);
        this.chart.changes = {};
        if (!state.success) throw new Error(state.message);
        if (request.action === 'save') this.savedName = state.name ?? '';
        const added = JSON.stringify(state.added?.length ? state.added : null);
        const at = state.parts?.findIndex(({ place }) => JSON.stringify(place) === added) ?? -1;
        if (at >= 0) this.selected = at;
        this.form.refuse('', '');
        this.#say(state.message);
        await this.#show(state);
        return state;
      } catch (error) {
        if (!isOfForm) this.#showParts(); // the form keeps what was typed
        this.form.refuse(field, error.message);
        this.#say(error.message, 'error');
        return null;
      }
    });
    this.#queue = sent;
    return sent;
  }

  #set(values, isOfForm = false) {
    const { part } = this;
    const [field] = Object.keys(values);
    if (part && field) this.#act({ action: 'set', section: part.section, place: part.place, values }, field, isOfForm);
  }

  #sendLater() {
    clearTimeout(this.#timers.send);
    this.#timers.send = setTimeout(() => this.#flush(), SEND_MS);
  }

  // Send the changes made on the chart.
  #flush() {
    clearTimeout(this.#timers.send);
    const { changes } = this.chart;
    if (Object.keys(changes).length) this.#set(changes);
  }

  // Change values of the selected part on the chart, and send them a little later.
  change(values) {
    this.chart.change(values);
    this.#sendLater();
  }

  async #add() {
    this.#flush();
    const { bar, chart } = this;
    const at_m = chart.frame.middle.map((value) => Math.round(value * 10) / 10);
    await this.#act({ action: 'add', ...bar.chosen, at_m });
    chart.reveal();
    chart.draw();
  }

  #remove() {
    const { part } = this;
    if (!part || this.bar.remove.disabled) return;
    this.chart.changes = {};
    this.selected = -1;
    this.#act({ action: 'remove', section: part.section, place: part.place });
  }

  #save() {
    this.#flush();
    this.#act({ action: 'save', name: this.bar.name.value.trim() });
  }

  #apply() {
    this.#flush();
    this.#act({ action: 'apply' });
  }

  async #check() {
    const { state } = this;
    const found = await edit(this.station.bridge, { action: 'check' }).catch(() => null);
    if (!found?.success || found.edition !== state?.edition || this.message.dataset.kind === 'error') return;
    this.#say(found.mistakes?.length ? found.mistakes.join(' ') : WORDS.sound, found.mistakes?.length ? 'warn' : '');
  }

  #say(text, kind = '') {
    this.message.dataset.kind = kind;
    write(this.message, text);
  }
}
