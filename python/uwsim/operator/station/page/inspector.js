// The inspector: the simulator's live parameters by vehicle and topic, with unit, bounds and reset.
import { attempt, byId, draw, first } from './dom.js';
import { html, signal } from './vendor/preact.js';

const WORLD = 'world';
// Parameters of the physics that have a slider.
const PHYSICAL =
  /^water\.(density|surface_temp|bottom_temp|salinity|current_world)|^optics\.(visibility|coefficients\.|sun|wind|particles)|\.(mass_kg|ballast_kg|inertia_kg_m2|added_mass|drag)\b/;
const WIDE = 1000; // bounds farther apart than this are too wide for a slider
const SLIDER_STEPS = 200;
const SPAN = 10; // from a tenth to ten times a value
const DIGITS = 3; // of a value that a slider sets

export class Inspector {
  #topics = signal([]); // { key, owner, parameters }, of which each has its `title`
  #values = signal({}); // by name
  #wanted = signal({ words: /** @type {string[]} */ ([]), owner: '', isChanged: false });
  #trouble = signal('');
  #isPilot = signal(false);
  #typing = ''; // the name of the parameter whose field the operator is changing
  #session = -1; // of the simulator whose parameters are shown
  #isStale = true;
  #isReading = false;

  constructor(station) {
    this.station = station;
    this.element = byId('inspector');
    this.button = byId('inspect');
    this.button.addEventListener('click', () => this.toggle());
    for (const event of ['session', 'description']) station.addEventListener(event, () => this.#refresh());
    station.addEventListener('state', () => (this.#isPilot.value = station.isPilot));
    draw(this.element, () => this.#view());
  }

  get isOpen() {
    return !this.element.hidden;
  }

  toggle() {
    this.element.hidden = this.isOpen;
    this.button.setAttribute('aria-expanded', String(this.isOpen));
    if (!this.isOpen) this.button.focus();
    else if (this.#isStale) this.#refresh();
    if (this.isOpen) first(this.element, 'input').focus();
  }

  // Read the values of all parameters. Descriptions are read again only if a change or a different simulator has
  // introduced other parameters.
  async #refresh() {
    if (!this.isOpen || this.#isReading) {
      this.#isStale = true;
      return;
    }
    this.#isReading = true;
    try {
      do {
        this.#isStale = false;
        await this.#read();
      } while (this.#isStale);
      this.#trouble.value = '';
    } catch (error) {
      this.#isStale = true;
      this.#trouble.value = error.message;
    } finally {
      this.#isReading = false;
    }
  }

  async #read() {
    const { station } = this;
    const [names, { session }] = [await station.parameterNames(), station.description];
    const isKnown = names.toSorted().join() === Object.keys(this.#values.value).toSorted().join();
    if (session !== this.#session || !isKnown) {
      const [described, values] = [await station.describeParameters(names), await station.parameterValues(names)];
      [this.#topics.value, this.#values.value, this.#session] = [this.#sorted(described), values, session];
    } else this.#values.value = await station.parameterValues(names);
  }

  // Topics of parameters, by their owners.
  #sorted(parameters) {
    const vehicles = this.station.description.vehicles.map(({ name }) => name);
    const topics = new Map();
    for (const parameter of parameters) {
      const owner = vehicles.find((vehicle) => parameter.name.startsWith(`${vehicle}.`)) ?? WORLD;
      const path = (owner === WORLD ? parameter.name : parameter.name.slice(owner.length + 1)).split('.');
      const topic = path.length > 1 ? path.shift() : owner === WORLD ? 'mission' : 'body';
      const key = `${owner} · ${topic}`;
      if (!topics.has(key)) topics.set(key, { key, owner, parameters: [] });
      topics.get(key).parameters.push({ ...parameter, title: path.join('.') });
    }
    return [...topics.values()];
  }

  #isChanged = ({ name, default: usual }) => JSON.stringify(this.#values.value[name]) !== JSON.stringify(usual);

  // Show the values in effect after a request, whether it was accepted or refused.
  async #send(promise) {
    await attempt(promise);
    await this.#refresh();
  }

  #view() {
    const [topics, mayNot] = [this.#topics.value, !this.#isPilot.value];
    const { words, owner, isChanged } = this.#wanted.value;
    const all = topics.flatMap(({ parameters }) => parameters);
    const changed = all.filter(this.#isChanged).length;
    const matches = (parameter) =>
      words.every((word) => `${parameter.name} ${parameter.description}`.toLowerCase().includes(word)) &&
      (!isChanged || this.#isChanged(parameter));
    const listed = topics
      .filter((topic) => !owner || topic.owner === owner)
      .map(({ key, parameters }) => ({ key, parameters: parameters.filter(matches) }))
      .filter(({ parameters }) => parameters.length);
    const count = listed.reduce((sum, { parameters }) => sum + parameters.length, 0);
    const want = (part) => (this.#wanted.value = { ...this.#wanted.value, ...part });
    const open = (box) => box && (words.length || isChanged) && (box.open = true); // and it stays so
    return html`
      <header class="inspector-head">
        <h2 id="inspector-title">Parameters</h2>
        <button type="button" aria-label="Close" onClick=${() => this.toggle()}>✕</button>
      </header>
      <div class="inspector-tools">
        <input type="search" placeholder="Search" aria-label="Search parameters" autocomplete="off" spellcheck="false"
          onInput=${({ target }) => want({ words: target.value.toLowerCase().split(/\s+/).filter(Boolean) })} />
        <select aria-label="Owner of the parameters" onInput=${({ target }) => want({ owner: target.value })}>
          <option value="">All</option>
          ${[...new Set(topics.map((topic) => topic.owner))].map((each) => html`<option value=${each}>${each}</option>`)}
        </select>
      </div>
      <div class="inspector-tools">
        <label><input type="checkbox" onInput=${({ target }) => want({ isChanged: target.checked })} /> Changed only</label>
        <button type="button" disabled=${mayNot || !changed}
          onClick=${() => this.#send(this.station.resetParameters(null))}>Reset all</button>
      </div>
      <p class="caption" role="status">${this.#trouble.value || `${count} of ${all.length}, ${changed} changed`}</p>
      <div class="inspector-list" tabindex="0" role="group" aria-label="Parameters">
        ${listed.map(
          ({ key, parameters }) => html`
            <details key=${key} ref=${open}>
              <summary>${key} <small class="caption">${parameters.length}</small></summary>
              ${parameters.map((parameter) => this.#row(parameter, mayNot))}
            </details>
          `,
        )}
      </div>
    `;
  }

  #row(parameter, mayNot) {
    const { name, title, unit, description, low, high, optional } = parameter;
    const value = this.#values.value[name];
    const isChanged = this.#isChanged(parameter);
    const set = (wanted) => this.#send(this.station.setParameters({ [name]: wanted }));
    const bounds = low === null ? '' : `${low} to ${high}${optional ? ', or empty' : ''}`;
    return html`
      <div class="parameter" key=${name} title=${description} data-changed=${isChanged || null}>
        <span class="parameter-name">${title}</span>
        ${this.#field(parameter, value, set, { 'aria-label': unit ? `${name}, ${unit}` : name, disabled: mayNot })}
        <span class="caption">${unit}</span>
        <button type="button" aria-label="Reset ${name}" title="Restore the scenario’s value"
          disabled=${mayNot || !isChanged} onClick=${() => this.#send(this.station.resetParameters(name))}>↺</button>
        ${PHYSICAL.test(name) && slider(parameter, value, set, mayNot)}
        <small class="parameter-range">${bounds}</small>
      </div>
    `;
  }

  // The input for a parameter's type. Values other than numbers, flags and choices are written as JSON.
  #field({ name, type, choices, optional }, value, set, attributes) {
    if (type === 'flag')
      return html`
        <input type="checkbox" checked=${Boolean(value)} onChange=${({ target }) => set(target.checked)} ...${attributes} />
      `;
    if (choices.length && !optional)
      return html`
        <select value=${value} onChange=${({ target }) => set(choices[target.selectedIndex])} ...${attributes}>
          ${choices.map((choice) => html`<option value=${String(choice)}>${String(choice)}</option>`)}
        </select>
      `;
    const change = ({ target }) => {
      this.#typing = '';
      set(parsed(target.value.trim(), type));
    };
    return html`
      <input type="text" inputmode=${type === 'number' || typeof value === 'number' ? 'decimal' : 'text'}
        autocomplete="off" spellcheck="false" value=${this.#typing === name ? undefined : shown(value)}
        onInput=${() => (this.#typing = name)} onChange=${change} ...${attributes} />
    `;
  }
}

// An empty field means no value. Text that cannot be parsed is sent as it is, and the simulator reports the rule.
function parsed(text, type) {
  if (text === '') return null;
  try {
    return type === 'text' ? text : JSON.parse(text);
  } catch {
    return text;
  }
}

// The text of a value in its field.
const shown = (value) => (value === null ? '' : typeof value === 'object' ? JSON.stringify(value) : String(value));

/** A parameter's slider, or null if it has no bounds: from a tenth to ten times a positive scenario's value, by its
 * logarithm; else over the bounds or, where these are too wide, to twice the value. ends: the input's attributes.
 * @returns {{ ends: object, placeOf: (value: number) => number, valueAt: (place: number) => number } | null}
 */
function sliderScale({ type, low, high, default: usual }) {
  if (type !== 'number' || typeof usual !== 'number' || low === null) return null;
  const isLog = low >= 0 && usual > 0;
  const [least, most] = isLog
    ? [Math.max(low, usual / SPAN), Math.min(high, usual * SPAN)].map(Math.log10)
    : high - low <= WIDE
      ? [low, high]
      : [Math.max(low, Math.min(0, 2 * usual)), Math.min(high, 2 * Math.abs(usual))];
  if (!(most > least)) return null;
  return {
    ends: { min: String(least), max: String(most), step: String((most - least) / SLIDER_STEPS) },
    placeOf: (value) => (isLog ? Math.log10(value || 10 ** least) : value),
    valueAt: (place) => (isLog ? Number((10 ** place).toPrecision(DIGITS)) : place),
  };
}

function slider(parameter, value, set, mayNot) {
  const scale = sliderScale(parameter);
  if (!scale) return null;
  const show = ({ target }) => {
    first(target.parentElement, 'input').value = String(scale.valueAt(Number(target.value)));
  };
  return html`
    <input type="range" ...${scale.ends} aria-label="${parameter.name}, slider" aria-valuetext=${String(value)}
      value=${scale.placeOf(value ?? 0)} disabled=${mayNot} onInput=${show}
      onChange=${({ target }) => set(scale.valueAt(Number(target.value)))} />
  `;
}
