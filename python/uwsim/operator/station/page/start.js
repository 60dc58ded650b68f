// The start screen: starts a simulator, or connects to a running one.
import { byId, el, first, write } from './dom.js';
import { Preview } from './preview.js';
import { address, number, options } from './start_inputs.js';

const GROUPS = {
  own: 'Yours',
  saved: 'Saved sessions',
  lakes: 'Lakes',
  sea: 'Sea',
  structures: 'Wrecks and structures',
  basins: 'Pools and basins',
};

const CHECK_MS = 250;
const OWN = 'From the scenario';
const SAVED = 'saved:';
const SAVED_HINT = 'Continues a session saved here, including its map; only the speed can be changed.';
const OF_SCENARIO = ['vehicle', 'sonar', 'tilt_deg', 'mission_time_s', 'seed', 'link'];

// The form's fields; one without bounds or placeholder is a choice from the catalog.
const FIELDS = {
  scenario: { title: 'Scenario', wide: true },
  vehicle: { title: 'Vehicle' },
  sonar: { title: 'Sonar' },
  tilt_deg: { title: 'Sonar head at the start' },
  mission_time_s: {
    title: 'Mission time',
    bounds: { min: 1, step: 1 },
    unit: 's',
    hint: 'This is also how long the battery lasts.',
  },
  seed: { title: 'Seed', bounds: { min: 0, step: 1 }, hint: 'The same seed and the same controls give the same run.' },
  speed: { title: 'Speed' },
  link: { title: 'Link to the vehicle' },
  rosbridge_host: {
    title: 'Address',
    placeholder: 'none: fly without ROS',
    hint: 'The simulator joins this rosbridge_server, as with uwsim ros connect, so that your nodes can fly it.',
  },
  rosbridge_port: {
    title: 'Port',
    bounds: { min: 1, max: 65535, step: 1 },
    hint: 'If empty: 9090, the default of rosbridge_server.',
  },
  host: { title: 'Host', placeholder: '127.0.0.1', hint: 'A uwsim server, such as uwsim serve lake --station.' },
  port: { title: 'Port', bounds: { min: 1, max: 65535, step: 1 } },
};

// An entry of the catalog as a choice.
const choice = ({ name, title = name, description }) => ({ value: name, text: title, hint: description });

export class StartScreen {
  #fields = new Map(); // name: { box, input, hint, wrong }
  #timer = 0;
  #checks = 0;
  #errors = {}; // those that are shown, by field
  #isNew = true; // the choice, since Start reported its errors
  #preview = new Preview();
  /** @type {HTMLButtonElement} */
  edit;
  /** @type {HTMLButtonElement} */
  fresh;
  /** @type {HTMLElement} */
  whereSet;
  /** @type {HTMLElement} */
  ownSet;
  /** @type {HTMLElement} */
  paceSet;
  /** @type {HTMLElement} */
  rosSet;
  /** @type {HTMLElement} */
  otherSet;
  #task = 'fly';
  #isToSurvey = false; // what was started
  /** @type {Promise<void> | null} */
  #asking = null; // for the catalog
  #isOld = false; // whether the catalog's list of saved sessions is outdated

  // onCatalog(catalog): called when the catalog has arrived. editor: edits the chosen scenario.
  constructor(station, onCatalog, editor) {
    this.station = station;
    this.onCatalog = onCatalog;
    this.editor = editor;
    this.form = /** @type {HTMLFormElement} */ (document.getElementById('start-form'));
    this.button = first(this.form, 'button[type=submit]');
    this.form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.#submit();
    });
    this.form.addEventListener('input', () => this.#later());
    station.addEventListener('session', () => {
      this.#isOld = true; // that session may have been saved
    });
  }

  // Ask once, however many states arrive meanwhile: a list that is made again takes the focus from its buttons.
  async show() {
    if (this.catalog && !this.#isOld) return;
    await (this.#asking ??= this.#ask().finally(() => (this.#asking = null)));
  }

  async #ask() {
    this.#showMessage('Loading the available choices …');
    try {
      do {
        this.#isOld = false;
        this.catalog = await this.station.catalog();
      } while (this.#isOld);
    } catch (error) {
      this.#showMessage(error.message, 'error');
      return;
    }
    this.#build();
    this.onCatalog(this.catalog);
    this.#mark(this.#errors); // the fields are new; a list that comes late must not erase the errors of Start
    this.#check(); // the server builds the simulator for a valid choice in advance, so that it is ready at Start
  }

  #build() {
    const { scenarios, vehicles, sonars, tilts_deg, links, speeds, defaults, saves = [] } = this.catalog;
    const before = [...this.#fields].map(([name, { input }]) => [name, input.value]);
    const saved = saves.map((name) => ({
      value: SAVED + name,
      text: `Continue “${name}”`,
      hint: SAVED_HINT,
      group: GROUPS.saved,
    }));
    const scenes = scenarios.map(({ name, description, group }) => ({
      value: name,
      text: name,
      hint: description,
      group: GROUPS[group],
    }));
    const own = { value: '', text: OWN };
    const paces = speeds.map((value) => ({ value, text: value ? `${value} × real time` : 'As fast as possible' }));
    const choices = {
      scenario: Object.values(GROUPS).flatMap((group) => [...scenes, ...saved].filter((each) => each.group === group)),
      vehicle: [own, ...vehicles.map(choice)],
      sonar: [own, ...sonars.map(choice)],
      tilt_deg: [
        own,
        ...tilts_deg.map((value) => ({
          value,
          text: value ? `${value}° down` : 'Level',
          hint: value
            ? 'A survey at constant depth needs it: its beams meet the bed.'
            : 'As the published simulator starts: level beams meet walls, not the bed. Tilt it in flight by , and .',
        })),
      ],
      speed: paces,
      link: links.map(choice),
    };
    const fields = (...names) => names.map((name) => this.#field(name, choices[name]));
    this.fresh = el('button', { type: 'button', className: 'new-scene', onclick: () => this.#edit(null) }, 'New scene');
    this.edit = el('button', { type: 'button', className: 'edit', onclick: () => this.#edit() }, 'Edit this scenario');
    const [scenario, ...mission] = fields('scenario', 'vehicle', 'sonar', 'tilt_deg', 'mission_time_s', 'seed');
    this.ownSet = this.#set('Mission', scenario, this.#preview.element, this.edit, this.fresh, ...mission);
    this.paceSet = this.#set('Time and link', ...fields('speed', 'link'));
    this.rosSet = this.#set('Your rosbridge', ...fields('rosbridge_host', 'rosbridge_port'));
    this.otherSet = this.#set('Address', ...fields('host', 'port'));
    this.whereSet = this.#set('Simulator', this.#where());
    byId('start-fields').replaceChildren(this.whereSet, this.ownSet, this.paceSet, this.rosSet, this.otherSet);
    for (const [name, value] of Object.entries({ ...defaults, host: '127.0.0.1', port: 9090 })) {
      const field = this.#fields.get(name);
      if (field && value !== null && value !== undefined) field.input.value = value;
    }
    for (const [name, value] of before) {
      const { input } = this.#fields.get(name);
      if (!input.options || [...input.options].some((option) => option.value === value)) input.value = value;
    }
    if (this.#task === 'survey') this.#showScenes();
    this.#showWhere();
    this.#showHints();
  }

  #where() {
    const place = (value, title, text) =>
      el(
        'label',
        {},
        el('input', {
          type: 'radio',
          name: 'where',
          value,
          checked: value === 'here',
          onchange: () => this.#showWhere(),
        }),
        el('b', {}, title),
        el('small', {}, text),
      );
    return el(
      'div',
      { className: 'choice', role: 'radiogroup', 'aria-label': 'Simulator' },
      place('here', 'Start a simulator here', 'In the process that serves this page'),
      place('there', 'Open another station', 'Goes to the page of a server elsewhere'),
    );
  }

  get isElsewhere() {
    return new FormData(this.form).get('where') === 'there';
  }

  #showWhere() {
    const isElsewhere = this.isElsewhere && !this.#isBuilding;
    this.ownSet.hidden = isElsewhere;
    this.paceSet.hidden = this.rosSet.hidden = isElsewhere || this.#isBuilding;
    this.fresh.hidden = !this.#isBuilding;
    this.whereSet.hidden = this.edit.hidden = this.#isBuilding;
    this.otherSet.hidden = !isElsewhere;
    for (const name of OF_SCENARIO) this.#fields.get(name).box.hidden = this.#isBuilding;
    write(this.button, this.#isBuilding ? 'Edit this scenario' : isElsewhere ? 'Connect' : 'Start');
    this.#soon();
  }

  #set(title, ...fields) {
    return el('fieldset', {}, el('legend', {}, title), ...fields);
  }

  #field(name, choices) {
    const { title, wide = false, unit = '', hint = '', bounds, placeholder } = FIELDS[name];
    const input = choices ? options(choices) : bounds ? number(bounds) : address(placeholder);
    input.id = `field-${name}`;
    input.name = name;
    const [note, wrong] = [
      el('p', { className: 'hint', id: `hint-${name}` }, hint),
      el('p', { className: 'wrong', id: `wrong-${name}`, role: 'alert' }),
    ];
    input.setAttribute('aria-describedby', `hint-${name} wrong-${name}`);
    const box = el(
      'div',
      { className: `field${wide ? ' wide' : ''}` },
      el('label', { htmlFor: input.id }, title),
      unit ? el('div', { className: 'with-unit' }, input, el('span', { 'aria-hidden': 'true' }, unit)) : input,
      note,
      wrong,
    );
    this.#fields.set(name, { box, input, hint: note, wrong, fixedHint: hint });
    return box;
  }

  #showHints() {
    for (const { input, hint, fixedHint } of this.#fields.values()) {
      write(hint, input.selectedOptions?.[0]?.dataset.hint ?? fixedHint);
    }
    this.edit.disabled = this.savedName !== '';
    for (const name of OF_SCENARIO) this.#fields.get(name).input.disabled = this.savedName !== '';
    const scenario = this.catalog?.scenarios.find(({ name }) => name === this.#fields.get('scenario').input.value);
    if (!scenario) return;
    this.#fields.get('mission_time_s').input.placeholder = `${scenario.mission_time_s} (from the scenario)`;
    this.#fields.get('seed').input.placeholder = `${scenario.seed} (from the scenario)`;
    const [vehicle] = scenario.vehicles;
    if (this.#fields.get('vehicle').input.value === '' && vehicle)
      write(
        this.#fields.get('vehicle').hint,
        scenario.vehicles.map(({ name, model }) => (name === model ? name : `${name}: ${model}`)).join(', '),
      );
    if (this.#fields.get('sonar').input.value === '')
      write(this.#fields.get('sonar').hint, this.#sonarText(scenario.sonar));
    const tilt = scenario.tilt_deg ?? null;
    if (this.#fields.get('tilt_deg').input.value === '')
      write(this.#fields.get('tilt_deg').hint, tilt === null ? '' : tilt ? `${tilt}° down` : 'Level');
  }

  // The name of a scenario's sonar: of a published one, whose name is a number, its maker's.
  #sonarText(name) {
    const sonar = this.catalog.sonars.find((each) => String(each.name) === name);
    return name === null ? 'none' : sonar?.kind === 'published' ? sonar.description : String(name);
  }

  // Return the choice; empty fields follow the scenario. Invalid numbers are sent as text, and the server reports them.
  get choice() {
    const value = (name) => this.#fields.get(name).input.value.trim();
    const numeric = (name) =>
      value(name) === '' ? null : Number.isNaN(Number(value(name))) ? value(name) : Number(value(name));
    const text = (name) => value(name) || null;
    const rosbridge = value('rosbridge_host') && {
      rosbridge_host: value('rosbridge_host'),
      rosbridge_port: numeric('rosbridge_port'),
    };
    if (this.savedName) return { saved: this.savedName, speed: numeric('speed'), ...rosbridge };
    return {
      scenario: text('scenario'),
      vehicle: text('vehicle'),
      sonar: text('sonar'),
      tilt_deg: numeric('tilt_deg'),
      mission_time_s: numeric('mission_time_s'),
      seed: numeric('seed'),
      speed: numeric('speed'),
      link: text('link'),
      ...rosbridge,
    };
  }

  // To build, the button is the one that edits the chosen scene. To survey, only scenes with a survey can be chosen, and
  // the sonar's head is down.
  showTask(task) {
    const hasTurned = (task === 'survey') !== (this.#task === 'survey');
    this.#task = task;
    if (!this.catalog) return;
    if (hasTurned) this.#showScenes();
    this.#showWhere();
  }

  get #isBuilding() {
    return this.#task === 'build';
  }

  #showScenes() {
    const isSurvey = this.#task === 'survey';
    const { input } = this.#fields.get('scenario');
    const surveyed = this.catalog.scenarios.filter(({ has_survey }) => has_survey).map(({ name }) => name);
    for (const option of input.options) option.hidden = option.disabled = isSurvey && !surveyed.includes(option.value);
    if (input.selectedOptions[0]?.disabled) [input.value] = surveyed;
    this.#fields.get('tilt_deg').input.value = isSurvey ? Math.max(...this.catalog.tilts_deg) : '';
    this.#later();
  }

  // Test if the session that begins was started to survey; true once.
  takesSurvey() {
    const isToSurvey = this.#isToSurvey;
    this.#isToSurvey = false;
    return isToSurvey;
  }

  // Edit the chosen scenario, or a new one for null; one that is saved is then chosen.
  #edit(scenario = this.#fields.get('scenario').input.value) {
    this.editor.open(scenario, async (name) => {
      if (!name) return;
      this.#isOld = true;
      await this.show();
      this.#fields.get('scenario').input.value = name;
      this.#preview.forget();
      this.#later();
    });
  }

  // The name of the saved session to continue, if one is chosen.
  get savedName() {
    const { value } = this.#fields.get('scenario').input;
    return value.startsWith(SAVED) ? value.slice(SAVED.length) : '';
  }

  #later() {
    this.#isNew = true;
    this.#soon();
  }

  #soon() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#check(), CHECK_MS);
  }

  async #check() {
    if (!this.catalog) return;
    this.#showHints();
    const count = (this.#checks += 1);
    const answer = this.isElsewhere
      ? { errors: this.#addressErrors() }
      : await this.station.check(this.choice).catch(() => null);
    if (!answer || count !== this.#checks) return;
    if (this.#isNew) this.#mark(answer.errors ?? {});
    const scenario = this.isElsewhere || this.savedName ? '' : this.#fields.get('scenario').input.value;
    this.#preview.show(scenario, (suffix) => this.station.href(`/preview/${encodeURIComponent(scenario)}${suffix}`));
  }

  #addressErrors() {
    const [host, port] = ['host', 'port'].map((name) => this.#fields.get(name).input.value.trim());
    const errors = {};
    if (!/^[\w.:[\]-]+$/.test(host)) errors.host = `host = '${host}': must be a name or an address, such as 127.0.0.1`;
    if (!/^\d+$/.test(port) || port < 1 || port > 65535) errors.port = `port = '${port}': must be in [1, 65535]`;
    return errors;
  }

  // Show each error at its field; return whether there are any.
  #mark(errors) {
    this.#errors = errors;
    for (const [name, { box, input, wrong }] of this.#fields) {
      const text = errors[name] ?? '';
      write(wrong, text);
      box.toggleAttribute('data-wrong', text !== '');
      input.setAttribute('aria-invalid', String(text !== ''));
    }
    const others = Object.entries(errors)
      .filter(([name]) => !this.#fields.has(name))
      .map(([, text]) => text);
    this.#showMessage(others.join(' '), others.length ? 'error' : '');
    return Object.keys(errors).length > 0;
  }

  async #submit() {
    if (!this.catalog) return;
    this.#showHints();
    if (this.#isBuilding) {
      if (!this.savedName) this.#edit();
      return;
    }
    clearTimeout(this.#timer); // a check that ends later, or of the same choice, must not erase the errors of Start
    this.#checks += 1;
    this.#isNew = false;
    if (this.isElsewhere) {
      const [host, port] = ['host', 'port'].map((name) => this.#fields.get(name).input.value.trim());
      if (!this.#mark(this.#addressErrors())) location.href = `http://${host}:${port}/`;
      return;
    }
    this.button.disabled = true;
    this.#showMessage('Starting …');
    this.#isToSurvey = this.#task === 'survey';
    try {
      const answer = await this.station.start(this.choice);
      this.#isToSurvey &&= answer.success;
      if (answer.success) this.#showMessage('');
      else if (this.#mark(answer.errors ?? {})) first(this.form, '[aria-invalid=true]')?.focus();
      if (!answer.success && answer.message) this.#showMessage(answer.message, 'error');
    } catch (error) {
      this.#showMessage(error.message, 'error');
    }
    this.button.disabled = false;
  }

  #showMessage(text, kind = '') {
    const message = byId('start-message');
    write(message, text);
    message.dataset.kind = kind;
  }
}
