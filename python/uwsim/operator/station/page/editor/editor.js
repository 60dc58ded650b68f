// The scene editor: a chart, a 3D view, a table and a form of one scenario, which the server holds, checks and writes.
import { openDialog } from '../dialogs/dialog.js';
import { byId, draw, el, first, toast, write } from '../dom.js';
import { html, render, signal } from '../vendor/preact.js';
import { edit, editForms } from '../wire/messages.js';
import { bar } from './bar.js';
import { Brush } from './brush.js';
import { EditorChart } from './chart.js';
import { form, settle } from './form.js';
import { placeOf } from './geometry.js';
import { chartKey, editorKey } from './keys.js';
import { EditorMeshes } from './meshes.js';
import { EditedParts } from './parts.js';
import { EditorScene } from './scene.js';
import { table, tableKey } from './table.js';

const SEND_MS = 250; // after the last key or notch of the wheel
const CHECK_MS = 800; // after the last change
const RETRY_MS = 2000;
const ABOUT = { objects: 'object', obstacles: 'obstacle', props: 'of' }; // a goal's field, by section
const AGAIN_MS = 2000; // between attempts to continue after a lost connection

/** @typedef {import('../wire/messages.js').EditState} EditState */

const tenths = (place) => place.map((value) => Math.round(value * 10) / 10);
const requestTo = (scenario) =>
  scenario === null ? { action: 'new' } : { action: 'open', ...(scenario ? { scenario } : {}) };

export class SceneEditor {
  /** @type {EditState | null} */
  state = null;
  /** @type {EditorScene | null} */
  scene = null; // made when it is first shown
  #client = ''; // this page's identity when it opened the scenario
  savedName = ''; // under which it was saved since it was opened
  #wanted = signal({ section: '', kind: '', vehicle: 0, values: {} }); // what the person has chosen to add
  wrong = signal({ name: '', text: '' }); // the field that was refused, and why
  #timers = { send: 0, check: 0 };
  /** @type {Promise<any>} */
  #queue = Promise.resolve();
  /** @type {import('../wire/messages.js').BedGrid | null} */
  #bed = null;
  /** @type {Float32Array | null} */
  heights = null; // of the grid
  /** @type {string | null} */
  #opened = ''; // see open
  /** @type {(name: string) => void} */
  #onClose = () => {};

  constructor(station) {
    this.station = station;
    this.acts = {
      add: () => this.#add(),
      remove: () => this.#remove(),
      earlier: () => this.#move(-1),
      later: () => this.#move(1),
      undo: () => this.#step('undo'),
      redo: () => this.#step('redo'),
      revert: () => this.#step('revert'),
      fit: () => this.view.fit(),
      turn: () => this.#turn(),
      save: () => this.#save(),
      apply: () => this.#apply(),
    };
    this.brush = new Brush();
    this.parts = new EditedParts();
    this.chart = new EditorChart(this.parts, this.brush);
    this.meshes = new EditorMeshes(station.bridge, (path) => station.href(`${this.state?.files}/${path}`));
    this.parts.addEventListener('pick', (event) => this.pick(/** @type {CustomEvent} */ (event).detail, true));
    this.parts.addEventListener('painted', (event) => this.#paint(/** @type {CustomEvent} */ (event).detail));
    this.parts.addEventListener('done', () => this.#sendLater());
    station.addEventListener('state', () => this.#goOn());
    byId('editor-dialog').addEventListener('close', () => this.#left());
    // On the window, since the element that has the focus may vanish with a change.
    addEventListener('keydown', (event) => this.#isShown && editorKey(event, this.acts));
    this.element = el('div', { className: 'editor' });
    render(this.#frame(), this.element);
    this.ground = this.#box('ground');
    this.message = this.#box('message');
    this.source = this.#box('source');
    this.ground.append(this.chart.canvas);
    for (const [name, view] of Object.entries({ bar, table, form }))
      draw(this.#box(name), () => view(this), [this.parts, 'change']);
  }

  #box(name) {
    return first(this.element, `.editor-${name}`);
  }

  #frame() {
    const keys =
      'Arrows move (Shift 10 m, Alt 0.1 m), Q E turn, Page Up Down raise and lower, N P choose, A adds, V shows 3D, B takes the brush, F2 renames, Delete removes, Enter goes to the form, + − F zoom';
    return html`
      <div class="editor-bar" role="toolbar" aria-label="Tools of the editor" />
      <div class="editor-ground" onKeyDown=${(event) => chartKey(event, this, this.acts)}
        onDragOver=${(event) => event.preventDefault()} onDrop=${(event) => this.#drop(event)} />
      <div class="editor-side">
        <div class="editor-table" onKeyDown=${(event) => tableKey(event, this)} />
        <div class="editor-form" onChange=${settle} />
        <details name="editor-file"><summary>The file</summary><pre class="editor-source" tabindex="0" /></details>
      </div>
      <footer class="editor-foot"><p class="editor-message" role="status" /><p class="hint">${keys}</p></footer>
    `;
  }

  /** Open a scenario, '' for that of the running simulator, null for a new one; the server still has what was not saved. onClose(name):
   * called with the name under which it was saved, or ''.
   * @param {string | null} scenario
   * @param {(name: string) => void} onClose
   */
  open(scenario, onClose = () => {}) {
    this.#queue = this.#queue.then(() => this.#open(scenario, onClose)); // a closing that comes late is after it
    return this.#queue;
  }

  async #open(scenario, onClose) {
    const { bridge } = this.station;
    try {
      if (!this.parts.sections.length) {
        const found = await editForms(bridge);
        if (!found.success) throw new Error(found.message);
        this.parts.sections = found.sections;
      }
      const state = await edit(bridge, requestTo(scenario));
      if (!state.success) throw new Error(state.message);
      [this.savedName, this.#onClose, this.#bed, this.#opened] = ['', onClose, null, scenario];
      [this.parts.selected, this.parts.changes, this.parts.mark, this.#client] = [-1, {}, null, this.station.id];
      this.#showParts(); // with nothing chosen: stills of the scene before are not there any more
      openDialog(byId('editor-dialog'), `Scene editor: ${state.name}`, this.element);
      const input = /** @type {HTMLInputElement} */ (/** @type {unknown} */ (this.#box('name')));
      input.defaultValue = input.value = (state.name ?? '').replace(/\.ya?ml$/, '').replace(/.*\//, '');
      this.#say(state.message);
      await this.#show(state);
      this.view.canvas.focus();
    } catch (error) {
      toast(error.message, 'error');
    }
  }

  get #isShown() {
    return byId('editor-dialog').open && this.element.isConnected;
  }

  // After a lost connection, under a new identity, continue with what the server kept.
  #goOn() {
    const { id, bridge } = this.station;
    if (!this.#isShown || !id || id === this.#client) return;
    this.#client = id;
    const { name, text } = this.state ?? {};
    const reopen = async () => {
      try {
        const isOfFile = this.#opened || (this.#opened === null && this.savedName);
        const state = await edit(bridge, requestTo(isOfFile ? (name ?? '') : this.#opened));
        if (!state.success) throw new Error(state.message);
        this.#say(
          state.text === text ? state.message : 'The server was started again: what was not saved is lost.',
          state.text === text ? '' : 'error',
        );
        await this.#show(state);
      } catch (error) {
        this.#say(error.message, 'error');
        setTimeout(() => {
          this.#client = '';
          this.#goOn();
        }, AGAIN_MS);
      }
    };
    this.#queue = this.#queue.then(reopen);
    this.#flush();
  }

  // Send what is left, and let others edit if nothing is unsaved. A dialog's event comes with the next frame of the
  // page, when it may be open again.
  #left() {
    this.#flush();
    this.#queue = this.#queue.then(() => {
      if (this.#isShown) return null;
      this.#onClose(this.savedName);
      return this.state?.is_saved ? edit(this.station.bridge, { action: 'close' }).catch(() => null) : null;
    });
  }

  // The sections of which a person can add parts.
  get offered() {
    return this.parts.sections.filter(({ name }) => name !== 'starts');
  }

  // What the person has chosen to add, or the first that is offered.
  get chosen() {
    const { section, kind, vehicle, values } = this.#wanted.value;
    const found = this.offered.find(({ name }) => name === section) ?? this.offered[0];
    const kinds = found?.kinds.map((each) => each.kind) ?? [];
    const isKind = kinds.includes(kind);
    return { section: found?.name ?? '', kind: (isKind ? kind : kinds[0]) ?? '', vehicle: Number(vehicle), values };
  }

  choose(wanted) {
    this.#wanted.value = { ...this.#wanted.value, values: {}, ...wanted };
  }

  // The files that it needs, of which none is packaged.
  get asked() {
    return this.parts.fieldsOf(this.chosen).filter(({ type, is_required, start }) => {
      return type === 'file' && is_required && start === null;
    });
  }

  get isRemovable() {
    return Boolean(this.part && this.part.section !== 'starts');
  }

  get selected() {
    return this.parts.selected;
  }

  get part() {
    return this.state?.parts?.[this.selected];
  }

  // The chart or the 3D view, whichever is shown.
  get view() {
    return this.scene?.canvas.isConnected ? this.scene : this.chart;
  }

  // Show the 3D view in place of the chart, or the chart again.
  #turn() {
    this.scene ??= new EditorScene(this.parts, (path) => this.station.load(path));
    const isScene = this.view === this.chart;
    this.ground.replaceChildren(...(isScene ? this.scene.element : [this.chart.canvas]));
    this.#showParts();
    if (isScene) this.#showScene(true, true);
    this.view.reveal();
    this.view.canvas.focus();
  }

  #showScene(isNewBed, isOther) {
    if (!this.state?.grid || !this.heights || this.view === this.chart) return;
    if (isNewBed) this.scene?.showBed(this.heights, this.state.grid, isOther);
    this.scene?.showSolids(this.state);
  }

  pick(index, isOnChart = false) {
    this.#flush();
    this.parts.selected = index;
    this.refuse();
    this.#showParts();
    if (!isOnChart) this.view.reveal();
  }

  async #show(state) {
    const isNew = state.text !== this.state?.text;
    this.state = state;
    const { grid, parts } = state;
    if (this.selected >= parts.length) this.parts.selected = -1;
    this.source.textContent = state.text;
    this.#showParts();
    const isNewBed = JSON.stringify(grid) !== JSON.stringify(this.#bed);
    const isOther = JSON.stringify({ ...grid, edition: 0 }) !== JSON.stringify({ ...this.#bed, edition: 0 });
    if (isNewBed) {
      this.#bed = grid;
      this.heights = new Float32Array(await (await this.station.load(`${state.files}/terrain.f32`)).arrayBuffer());
      this.chart.showBed(this.heights, grid, isOther);
    }
    this.#showScene(isNewBed, isOther);
    if (isNew) this.#checkSoon(CHECK_MS);
  }

  #showParts() {
    this.parts.show(this.state?.parts ?? [], this.selected);
  }

  // Show why a field was refused; none without arguments.
  refuse(name = '', text = '') {
    this.wrong.value = { name, text };
  }

  // Send a request after those before it, and show the answer or the refusal. Return the answer, null after a refusal.
  #act(request, field = '', isOfForm = false) {
    const sent = this.#queue.then(async () => {
      try {
        const state = await edit(this.station.bridge, request);
        this.parts.changes = {};
        if (!state.success) throw new Error(state.message);
        if (request.action === 'save') this.savedName = state.name ?? '';
        const added = JSON.stringify(state.added?.length ? state.added : null);
        const at = state.parts?.findIndex(({ place }) => JSON.stringify(place) === added) ?? -1;
        if (at >= 0) [this.parts.selected, this.parts.mark] = [at, null];
        this.refuse();
        this.#say(state.message);
        await this.#show(state);
        return state;
      } catch (error) {
        if (!isOfForm) this.#showParts(); // the form keeps what was typed
        this.refuse(field, error.message);
        this.#say(error.message, 'error');
        return null;
      }
    });
    this.#queue = sent;
    return sent;
  }

  set(values, isOfForm = true) {
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
    const { changes } = this.parts;
    if (Object.keys(changes).length) this.set(changes, false);
  }

  // Change values of the selected part, and send them a little later.
  change(values) {
    this.parts.change(values);
    this.#sendLater();
  }

  async #add() {
    this.#flush();
    const { mark } = this.parts;
    const { chosen } = this;
    const at_m = mark && this.view.sees(mark) ? mark : tenths(this.#placeAbout(chosen) ?? this.view.middle);
    const values = { ...chosen.values, ...this.#about(chosen) };
    if (this.brush.isOn) this.#paint([at_m]);
    else await this.#act({ action: 'add', ...chosen, at_m, values });
    this.view.reveal();
  }

  // The place of the chosen body, at which a goal is added.
  #placeAbout({ section }) {
    const part = section === 'goals' && ABOUT[this.part?.section ?? ''] ? this.parts.at(this.selected) : null;
    return part && placeOf(part, this.parts.fieldsOf(part));
  }

  // A goal that is added is about the chosen body, if its kind has a field for it.
  #about(chosen) {
    const { part } = this;
    const field = chosen.section === 'goals' && part ? ABOUT[part.section] : undefined;
    const isOne = this.parts.fieldsOf(chosen).some(({ name }) => name === field);
    return part && field && isOne ? { [field]: part.name } : {};
  }

  // Upload a mesh that was dropped, and add an obstacle of it there.
  async #drop(event) {
    event.preventDefault();
    const [file] = event.dataTransfer?.files ?? [];
    if (!file) return;
    const { view } = this;
    const at_m = tenths(view === this.chart ? this.chart.frame.place([event.offsetX, event.offsetY]) : view.middle);
    try {
      this.#say(`Uploading ${file.name} …`);
      const values = { file: await this.meshes.upload(file), scale: 1 };
      await this.#act({ action: 'add', section: 'obstacles', kind: 'mesh', at_m, values });
    } catch (error) {
      this.#say(error.message, 'error');
    }
  }

  #paint(line_m) {
    this.#act({ action: 'add', section: 'strokes', at_m: line_m[0], values: this.brush.stroke(line_m) });
  }

  #step(action) {
    this.#flush();
    this.#act({ action });
  }

  #remove() {
    const { part } = this;
    if (!part || !this.isRemovable) return;
    [this.parts.changes, this.parts.selected] = [{}, -1];
    this.#act({ action: 'remove', section: part.section, place: part.place });
  }

  // Let the chosen goal change places with the one before or after it.
  #move(by) {
    const { part } = this;
    const goals = this.state?.parts?.filter(({ section }) => section === 'goals') ?? [];
    const to = part ? goals.indexOf(part) + by : -1;
    if (part?.section !== 'goals' || !goals[to]) return;
    this.#flush();
    this.#act({ action: 'move', section: 'goals', place: part.place, to });
  }

  #save() {
    this.#flush();
    this.#act({ action: 'save', name: this.#box('name').value.trim() });
  }

  #apply() {
    this.#flush();
    this.#act({ action: 'apply' });
  }

  #checkSoon(wait_ms) {
    clearTimeout(this.#timers.check);
    this.#timers.check = setTimeout(() => this.#check(), wait_ms);
  }

  async #check() {
    const { state } = this;
    const found = await edit(this.station.bridge, { action: 'check' }).catch(() => null);
    if (!found?.success && state && this.state === state) this.#checkSoon(RETRY_MS); // a late or refused answer
    if (!found?.success || found.edition !== state?.edition || this.message.dataset.kind === 'error') return;
    const has = (wanted) => state?.parts?.some(({ section }) => section === wanted);
    if (found.mistakes?.length) this.#say(found.mistakes.join(' '), 'warn');
    else
      this.#say(
        (has('survey')
          ? 'No mistakes: the scenario can be built, and its survey be planned.'
          : 'No mistakes: the scenario can be built. It has no survey.') +
          (has('exercise') ? ' Its exercise can be flown.' : ''),
      );
  }

  #say(text, kind = '') {
    this.message.dataset.kind = kind;
    write(this.message, text);
  }
}
