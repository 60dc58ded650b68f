// The start screen: starts a simulator, or connects to a running one.
import { byId, draw, first } from './dom.js';
import { Preview } from './preview.js';
import { html, signal } from './vendor/preact.js';

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
const DOWN = 'A survey at constant depth needs it: its beams meet the bed.';
const LEVEL = 'As the published simulator starts: level beams meet walls, not the bed. Tilt it in flight by , and .';
const SAVED = 'saved:';
const SAVED_HINT = 'Continues a session saved here, including its map; only the speed can be changed.';
const HERE = { host: '127.0.0.1', port: '9090' };
const NUMBERS = new Set(['tilt_deg', 'mission_time_s', 'seed', 'speed', 'rosbridge_port', 'port']);
const OF_SCENARIO = ['vehicle', 'sonar', 'tilt_deg', 'mission_time_s', 'seed', 'link'];

// The form's fields. Any text may be written in that of a number, and the server reports why it is refused.
const FIELDS = {
  scenario: { title: 'Scenario', wide: true },
  vehicle: { title: 'Vehicle' },
  sonar: { title: 'Sonar' },
  tilt_deg: { title: 'Sonar head at the start' },
  mission_time_s: { title: 'Mission time', unit: 's', hint: 'This is also how long the battery lasts.' },
  seed: { title: 'Seed', hint: 'The same seed and the same controls give the same run.' },
  speed: { title: 'Speed' },
  link: { title: 'Link to the vehicle' },
  rosbridge_host: {
    title: 'Address',
    placeholder: 'none: fly without ROS',
    hint: 'The simulator joins this rosbridge_server, as with uwsim ros connect, so that your nodes can fly it.',
  },
  rosbridge_port: { title: 'Port', hint: 'If empty: 9090, the default of rosbridge_server.' },
  host: { title: 'Host', placeholder: '127.0.0.1', hint: 'A uwsim server, such as uwsim serve lake --station.' },
  port: { title: 'Port' },
};

const tiltText = (tilt_deg) => (tilt_deg ? `${tilt_deg}° down` : 'Level');

// An entry of the catalog as a choice.
const choice = ({ name, title = name, description, group = '' }) => ({
  value: name,
  text: title,
  hint: description,
  group: GROUPS[group],
});

const set = (title, isHidden, ...contents) => html`
  <fieldset hidden=${isHidden}><legend>${title}</legend>${contents}</fieldset>
`;

// The options of a choice; those of a group, if there are any, stand below its name.
const options = (choices) =>
  [...Map.groupBy(choices, ({ group }) => group)].map(([group, members]) => {
    const all = members.map(
      ({ value, text, isOff }) =>
        html`<option value=${String(value)} disabled=${isOff} hidden=${isOff}>${text}</option>`,
    );
    return group ? html`<optgroup label=${group}>${all}</optgroup>` : all;
  });

export class StartScreen {
  #catalog = signal(null);
  #values = signal({}); // of the fields, as texts
  #errors = signal({}); // those that are shown, by field
  #message = signal({ text: '', kind: '' });
  #task = signal('fly');
  #isElsewhere = signal(false);
  #isStarting = signal(false);
  #timer = 0;
  #checks = 0;
  #isNew = true; // the choice, since Start reported its errors
  #preview = new Preview();
  #isToSurvey = false; // what was started
  /** @type {Promise<void> | null} */
  #asking = null; // for the catalog
  #isOld = false; // whether the catalog's list of saved sessions is outdated

  // onCatalog(catalog): called when the catalog has arrived. editor: edits the chosen scenario.
  constructor(station, onCatalog, editor) {
    this.station = station;
    this.onCatalog = onCatalog;
    this.editor = editor;
    this.form = byId('start-form');
    this.form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.#submit();
    });
    draw(this.form, () => this.#view());
    station.addEventListener('session', () => {
      this.#isOld = true; // that session may have been saved
    });
  }

  // Ask once, however many states arrive meanwhile: a list that is made again takes the focus from its buttons.
  async show() {
    if (this.#catalog.value && !this.#isOld) return;
    await (this.#asking ??= this.#ask().finally(() => (this.#asking = null)));
  }

  async #ask() {
    this.#say('Loading the available choices …');
    try {
      do {
        this.#isOld = false;
        this.#catalog.value = await this.station.catalog();
      } while (this.#isOld);
    } catch (error) {
      this.#say(error.message, 'error');
      return;
    }
    const catalog = this.#catalog.value;
    const kept = Object.entries({ ...HERE, ...catalog.defaults, ...this.#values.value }).filter(
      ([name, value]) => name in FIELDS && (value ?? '') !== '',
    );
    const values = Object.fromEntries(kept.map(([name, value]) => [name, String(value)]));
    for (const [name, choices] of Object.entries(this.#choices))
      if (!choices.some(({ value }) => String(value) === (values[name] ?? '')))
        values[name] = String(catalog.defaults[name] ?? choices[0].value);
    this.#values.value = values;
    if (this.#task.value === 'survey') this.#chooseSurveyed();
    this.onCatalog(catalog);
    this.#mark(this.#errors.value); // a list that comes late must not erase the errors of Start
    this.#check(); // the server builds the simulator for a valid choice in advance, so that it is ready at Start
  }

  // The choices { value, text, hint, group, isOff } of each field that has some.
  get #choices() {
    const { scenarios, vehicles, sonars, tilts_deg, links, speeds, saves = [] } = this.#catalog.value;
    const isSurvey = this.#task.value === 'survey';
    const scenes = [
      ...scenarios.map((each) => Object.assign(choice(each), { isOff: isSurvey && !each.has_survey })),
      ...saves.map((name) => ({
        value: SAVED + name,
        text: `Continue “${name}”`,
        hint: SAVED_HINT,
        group: GROUPS.saved,
        isOff: isSurvey,
      })),
    ];
    const own = { value: '', text: OWN };
    const tilts = tilts_deg.map((value) => ({ value, text: tiltText(value), hint: value ? DOWN : LEVEL }));
    return {
      scenario: Object.values(GROUPS).flatMap((group) => scenes.filter((each) => each.group === group)),
      vehicle: [own, ...vehicles.map(choice)],
      sonar: [own, ...sonars.map(choice)],
      tilt_deg: [own, ...tilts],
      speed: speeds.map((value) => ({ value, text: value ? `${value} × real time` : 'As fast as possible' })),
      link: links.map(choice),
    };
  }

  #view() {
    const { text, kind } = this.#message.value;
    const isBuilding = this.#isBuilding;
    const isElsewhere = this.#isElsewhere.value && !isBuilding;
    return html`
      <div id="start-fields" class="start-fields">${this.#catalog.value && this.#sets(isBuilding, isElsewhere)}</div>
      <footer class="start-foot">
        <p id="start-message" role="status" aria-live="polite" data-kind=${kind}>${text}</p>
        <button type="submit" class="primary big" disabled=${this.#isStarting.value}>
          ${isBuilding ? 'Edit this scenario' : isElsewhere ? 'Connect' : 'Start'}
        </button>
      </footer>
    `;
  }

  #sets(isBuilding, isElsewhere) {
    const choices = this.#choices;
    const fields = (...names) => names.map((name) => this.#field(name, choices[name], isBuilding));
    const place = (isThere, title, about) => html`
      <label>
        <input type="radio" name="where" checked=${this.#isElsewhere.value === isThere}
          onChange=${() => this.#change(this.#isElsewhere, isThere)} />
        <b>${title}</b><small>${about}</small>
      </label>
    `;
    const where = html`
      <div class="choice" role="radiogroup" aria-label="Simulator">
        ${place(false, 'Start a simulator here', 'In the process that serves this page')}
        ${place(true, 'Open another station', 'Goes to the page of a server elsewhere')}
      </div>
    `;
    const edits = html`
      <button type="button" class="edit" hidden=${isBuilding} disabled=${this.savedName !== ''}
        onClick=${() => this.#edit()}>Edit this scenario</button>
      <button type="button" class="new-scene" hidden=${!isBuilding} onClick=${() => this.#edit(null)}>New scene</button>
    `;
    const isHidden = isElsewhere || isBuilding;
    return [
      set('Simulator', isBuilding, where),
      set('Mission', isElsewhere, fields('scenario'), this.#preview.view(), edits, fields(...OF_SCENARIO.slice(0, -1))),
      set('Time and link', isHidden, fields('speed', 'link')),
      set('Your rosbridge', isHidden, fields('rosbridge_host', 'rosbridge_port')),
      set('Address', !isElsewhere, fields('host', 'port')),
    ];
  }

  #field(name, choices, isBuilding) {
    const { title, wide = false, unit = '', placeholder } = FIELDS[name];
    const isOfScenario = OF_SCENARIO.includes(name);
    const wrong = this.#errors.value[name] ?? '';
    const usual = this.#scenario?.[name];
    const attributes = {
      id: `field-${name}`,
      name,
      value: this.#value(name),
      'aria-describedby': `hint-${name} wrong-${name}`,
      'aria-invalid': wrong !== '',
      disabled: isOfScenario && this.savedName !== '',
      onInput: ({ target }) => this.#change(this.#values, { ...this.#values.value, [name]: target.value }),
    };
    const input = choices
      ? html`<select ...${attributes}>${options(choices)}</select>`
      : html`
          <input type="text" inputmode=${NUMBERS.has(name) && 'numeric'} autocomplete="off" spellcheck="false" ...${attributes}
            placeholder=${usual === undefined ? placeholder : `${usual} (from the scenario)`} />
        `;
    return html`
      <div class="field ${wide ? 'wide' : ''}" data-wrong=${wrong ? '' : null} hidden=${isBuilding && isOfScenario}>
        <label for="field-${name}">${title}</label>
        ${unit ? html`<div class="with-unit">${input}<span aria-hidden="true">${unit}</span></div>` : input}
        <p class="hint" id="hint-${name}">${this.#hint(name, choices)}</p>
        <p class="wrong" id="wrong-${name}" role="alert">${wrong}</p>
      </div>
    `;
  }

  // The hint of a field: of what is chosen, or of what the scenario has.
  #hint(name, choices = []) {
    const scenario = this.#scenario;
    const value = this.#value(name);
    if (scenario && value === '') {
      const { vehicles, sonar, tilt_deg: tilt = null } = scenario;
      if (name === 'vehicle' && vehicles.length)
        return vehicles.map(({ name: own, model }) => (own === model ? own : `${own}: ${model}`)).join(', ');
      if (name === 'sonar') return this.#sonarText(sonar);
      if (name === 'tilt_deg') return tilt === null ? '' : tiltText(tilt);
    }
    return choices.find((each) => String(each.value) === value)?.hint ?? FIELDS[name].hint ?? '';
  }

  // The chosen scenario's entry in the catalog.
  get #scenario() {
    return this.#catalog.value?.scenarios.find(({ name }) => name === this.#value('scenario'));
  }

  #value(name) {
    return this.#values.value[name] ?? '';
  }

  // The name of a scenario's sonar: of a published one, whose name is a number, its maker's.
  #sonarText(name) {
    const sonar = this.#catalog.value.sonars.find((each) => String(each.name) === name);
    return name === null ? 'none' : sonar?.kind === 'published' ? sonar.description : String(name);
  }

  // Return the choice; empty fields follow the scenario. Invalid numbers are sent as text, and the server reports them.
  get choice() {
    const read = (name) => {
      const text = this.#value(name).trim();
      return text === '' ? null : NUMBERS.has(name) && !Number.isNaN(Number(text)) ? Number(text) : text;
    };
    const all = (...names) => Object.fromEntries(names.map((name) => [name, read(name)]));
    const rosbridge = read('rosbridge_host') && all('rosbridge_host', 'rosbridge_port');
    if (this.savedName) return { saved: this.savedName, ...all('speed'), ...rosbridge };
    return { ...all('scenario', ...OF_SCENARIO, 'speed'), ...rosbridge };
  }

  // To build, the button is the one that edits the chosen scene. To survey, only scenes with a survey can be chosen, and
  // the sonar's head is down.
  showTask(task) {
    const hasTurned = (task === 'survey') !== (this.#task.value === 'survey');
    this.#task.value = task;
    if (hasTurned && this.#catalog.value) this.#chooseSurveyed();
    this.#soon();
  }

  get #isBuilding() {
    return this.#task.value === 'build';
  }

  #chooseSurveyed() {
    const isSurvey = this.#task.value === 'survey';
    const { scenarios, tilts_deg } = this.#catalog.value;
    const scenario = this.#scenario?.has_survey ? this.#scenario : scenarios.find(({ has_survey }) => has_survey);
    this.#change(this.#values, {
      ...this.#values.value,
      ...(isSurvey ? { scenario: scenario.name } : {}),
      tilt_deg: isSurvey ? String(Math.max(...tilts_deg)) : '',
    });
  }

  // Test if the session that begins was started to survey; true once.
  takesSurvey() {
    const isToSurvey = this.#isToSurvey;
    this.#isToSurvey = false;
    return isToSurvey;
  }

  // Edit the chosen scenario, or a new one for null; one that is saved is then chosen.
  #edit(scenario = this.#value('scenario')) {
    this.editor.open(scenario, async (name) => {
      if (!name) return;
      this.#isOld = true;
      await this.show();
      this.#preview.forget();
      this.#change(this.#values, { ...this.#values.value, scenario: name });
    });
  }

  // The name of the saved session to continue, if one is chosen.
  get savedName() {
    const value = this.#value('scenario');
    return value.startsWith(SAVED) ? value.slice(SAVED.length) : '';
  }

  // Set a part of the choice, and check it soon.
  #change(part, value) {
    part.value = value;
    this.#isNew = true;
    this.#soon();
  }

  #soon() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#check(), CHECK_MS);
  }

  async #check() {
    if (!this.#catalog.value) return;
    const count = (this.#checks += 1);
    const isElsewhere = this.#isElsewhere.value;
    const answer = isElsewhere
      ? { errors: this.#addressErrors() }
      : await this.station.check(this.choice).catch(() => null);
    if (!answer || count !== this.#checks) return;
    if (this.#isNew) this.#mark(answer.errors ?? {});
    const scenario = isElsewhere || this.savedName ? '' : this.#value('scenario');
    this.#preview.show(scenario, (suffix) => this.station.href(`/preview/${encodeURIComponent(scenario)}${suffix}`));
  }

  #addressErrors() {
    const [host, port] = ['host', 'port'].map((name) => this.#value(name).trim());
    const errors = {};
    if (!/^[\w.:[\]-]+$/.test(host)) errors.host = `host = '${host}': must be a name or an address, such as 127.0.0.1`;
    if (!/^\d+$/.test(port) || Number(port) < 1 || Number(port) > 65535)
      errors.port = `port = '${port}': must be in [1, 65535]`;
    return errors;
  }

  // Show each error at its field, and others below; return whether there are any.
  #mark(errors) {
    this.#errors.value = errors;
    const others = Object.entries(errors).flatMap(([name, text]) => (name in FIELDS ? [] : [text]));
    this.#say(others.join(' '), others.length ? 'error' : '');
    return Object.keys(errors).length > 0;
  }

  async #submit() {
    if (!this.#catalog.value) return;
    if (this.#isBuilding) {
      if (!this.savedName) this.#edit();
      return;
    }
    clearTimeout(this.#timer); // a check that ends later, or of the same choice, must not erase the errors of Start
    this.#checks += 1;
    this.#isNew = false;
    if (this.#isElsewhere.value) {
      if (!this.#mark(this.#addressErrors()))
        location.href = `http://${this.#value('host').trim()}:${this.#value('port').trim()}/`;
      return;
    }
    this.#isStarting.value = true;
    this.#say('Starting …');
    this.#isToSurvey = this.#task.value === 'survey';
    try {
      const answer = await this.station.start(this.choice);
      this.#isToSurvey &&= answer.success;
      const isWrong = this.#mark((!answer.success && answer.errors) || {});
      if (!answer.success && answer.message) this.#say(answer.message, 'error');
      await Promise.resolve(); // until the errors are drawn
      if (isWrong) first(this.form, '[aria-invalid=true]')?.focus();
    } catch (error) {
      this.#say(error.message, 'error');
    }
    this.#isStarting.value = false;
  }

  #say(text, kind = '') {
    this.#message.value = { text, kind };
  }
}
