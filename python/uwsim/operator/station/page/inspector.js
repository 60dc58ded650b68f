// The inspector: the simulator's live parameters by vehicle and topic, with unit, bounds and reset.
import { attempt, byId, el, write } from './dom.js';

const WORLD = 'world';
// Parameters of the physics that have a slider.
const PHYSICAL =
  /^water\.(density|surface_temp|bottom_temp|salinity|current_world)|^optics\.(visibility|coefficients\.|sun|wind|particles)|\.(mass_kg|ballast_kg|inertia_kg_m2|added_mass|drag)\b/;
const WIDE = 1000; // bounds farther apart than this are too wide for a slider
const SLIDER_STEPS = 200;
const SPAN = 10; // from a tenth to ten times a value
const DIGITS = 3; // of a value that a slider sets

export class Inspector {
  #rows = new Map(); // name: { box, inputs, reset, show(value), isChanged }
  #topics = [];
  #session = -1; // of the simulator whose parameters are shown
  #isStale = true;
  #isReading = false;

  constructor(station) {
    this.station = station;
    this.element = byId('inspector');
    this.search = el('input', {
      type: 'search',
      placeholder: 'Search',
      'aria-label': 'Search parameters',
      autocomplete: 'off',
      spellcheck: false,
    });
    this.owner = el('select', { 'aria-label': 'Owner of the parameters' });
    this.changed = el('input', { type: 'checkbox', id: 'inspector-changed' });
    this.count = el('p', { className: 'caption', role: 'status' });
    this.list = el('div', { className: 'inspector-list', tabIndex: 0, role: 'group', 'aria-label': 'Parameters' });
    this.resetAll = el(
      'button',
      { type: 'button', onclick: () => this.#send(station.resetParameters(null)) },
      'Reset all',
    );
    for (const input of [this.search, this.owner, this.changed]) input.addEventListener('input', () => this.#filter());
    this.element.append(
      el(
        'header',
        { className: 'inspector-head' },
        el('h2', { id: 'inspector-title' }, 'Parameters'),
        el('button', { type: 'button', 'aria-label': 'Close', onclick: () => this.toggle() }, '✕'),
      ),
      el('div', { className: 'inspector-tools' }, this.search, this.owner),
      el(
        'div',
        { className: 'inspector-tools' },
        el('label', { htmlFor: 'inspector-changed' }, this.changed, ' ', 'Changed only'),
        this.resetAll,
      ),
      this.count,
      this.list,
    );
    this.button = byId('inspect');
    this.button.addEventListener('click', () => this.toggle());
    for (const event of ['session', 'description']) station.addEventListener(event, () => this.#refresh());
    station.addEventListener('state', () => this.#enable());
  }

  get isOpen() {
    return !this.element.hidden;
  }

  toggle() {
    this.element.hidden = this.isOpen;
    this.button.setAttribute('aria-expanded', String(this.isOpen));
    if (!this.isOpen) this.button.focus();
    else if (this.#isStale) this.#refresh();
    if (this.isOpen) this.search.focus();
  }

  // Read the values of all parameters. Descriptions are read again only if a change or a different simulator has
  // introduced other parameters, so that the row being edited keeps the focus.
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
    } catch (error) {
      this.#isStale = true;
      write(this.count, error.message);
    } finally {
      this.#isReading = false;
    }
  }

  async #read() {
    const { station } = this;
    const [names, { session }] = [await station.parameterNames(), station.description];
    if (session !== this.#session || names.length !== this.#rows.size || names.some((name) => !this.#rows.has(name))) {
      this.#build(await station.describeParameters(names));
      this.#session = session;
    }
    for (const [name, value] of Object.entries(await station.parameterValues(names))) this.#rows.get(name).show(value);
    this.#filter();
  }

  #build(parameters) {
    const vehicles = this.station.description.vehicles.map(({ name }) => name);
    const ownerOf = (name) => vehicles.find((vehicle) => name.startsWith(`${vehicle}.`)) ?? WORLD;
    const topics = new Map();
    for (const parameter of parameters) {
      const owner = ownerOf(parameter.name);
      const path = (owner === WORLD ? parameter.name : parameter.name.slice(owner.length + 1)).split('.');
      const topic = path.length > 1 ? path.shift() : owner === WORLD ? 'mission' : 'body';
      const key = `${owner} · ${topic}`;
      if (!topics.has(key)) topics.set(key, { key, owner, rows: [] });
      topics.get(key).rows.push(this.#row(parameter, path.join('.')));
    }
    this.#topics = [...topics.values()];
    this.#rows = new Map(this.#topics.flatMap(({ rows }) => rows.map((row) => [row.name, row])));
    for (const topic of this.#topics) {
      topic.badge = el('small', { className: 'caption' });
      topic.box = el(
        'details',
        {},
        el('summary', {}, topic.key, ' ', topic.badge),
        ...topic.rows.map((row) => row.box),
      );
    }
    this.list.replaceChildren(...this.#topics.map(({ box }) => box));
    const owners = [...new Set(this.#topics.map(({ owner }) => owner))];
    const { value } = this.owner;
    this.owner.replaceChildren(
      el('option', { value: '' }, 'All'),
      ...owners.map((owner) => el('option', { value: owner }, owner)),
    );
    this.owner.value = owners.includes(value) ? value : '';
  }

  #row(parameter, title) {
    const { name, unit, description } = parameter;
    const set = (value) => this.#send(this.station.setParameters({ [name]: value }));
    const input = field(parameter, set);
    input.setAttribute('aria-label', unit ? `${name}, ${unit}` : name);
    const scaled = sliderOf(parameter, input, set);
    const reset = el('button', {
      type: 'button',
      'aria-label': `Reset ${name}`,
      title: 'Restore the scenario’s value',
      onclick: () => this.#send(this.station.resetParameters(name)),
    });
    reset.textContent = '↺';
    const box = el(
      'div',
      { className: 'parameter', title: description },
      el('span', { className: 'parameter-name' }, title),
      input,
      el('span', { className: 'caption' }, unit),
      reset,
      scaled?.slider,
      el('small', { className: 'parameter-range' }, boundsText(parameter)),
    );
    const row = {
      name,
      box,
      inputs: scaled ? [input, scaled.slider] : [input],
      reset,
      text: `${name} ${description}`.toLowerCase(),
    };
    row.show = (value) => {
      row.isChanged = JSON.stringify(value) !== JSON.stringify(parameter.default);
      box.toggleAttribute('data-changed', row.isChanged);
      fill(input, value);
      scaled?.show(value);
    };
    return row;
  }

  #filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let [shown, changed] = [0, 0];
    for (const { owner, rows, box, badge } of this.#topics) {
      let inTopic = 0;
      for (const row of rows) {
        if (row.isChanged) changed += 1;
        row.box.hidden =
          !words.every((word) => row.text.includes(word)) ||
          (this.owner.value !== '' && owner !== this.owner.value) ||
          (this.changed.checked && !row.isChanged);
        if (!row.box.hidden) inTopic += 1;
      }
      shown += inTopic;
      box.hidden = inTopic === 0;
      write(badge, String(inTopic));
      if (words.length || this.changed.checked) box.open = true;
    }
    write(this.count, `${shown} of ${this.#rows.size}, ${changed} changed`);
    this.#enable();
  }

  #enable() {
    if (!this.isOpen) return;
    const mayNot = !this.station.isPilot;
    for (const { inputs, reset, isChanged } of this.#rows.values()) {
      for (const input of inputs) input.disabled = mayNot;
      reset.disabled = mayNot || !isChanged;
    }
    this.resetAll.disabled = mayNot || ![...this.#rows.values()].some(({ isChanged }) => isChanged);
  }

  // Show the values in effect after a request, whether it was accepted or refused.
  async #send(promise) {
    await attempt(promise);
    await this.#refresh();
  }
}

// Return the input for a parameter's type. Values other than numbers, flags and choices are written as JSON.
function field({ type, value, choices, optional }, set) {
  if (type === 'flag') return el('input', { type: 'checkbox', onchange: ({ target }) => set(target.checked) });
  if (choices.length && !optional)
    return el(
      'select',
      { onchange: ({ target }) => set(choices[target.selectedIndex]) },
      ...choices.map((choice) => el('option', { value: String(choice) }, String(choice))),
    );
  const isNumber = type === 'number' || typeof value === 'number';
  return el('input', {
    type: 'text',
    inputMode: isNumber ? 'decimal' : 'text',
    autocomplete: 'off',
    spellcheck: false,
    oninput: ({ target }) => target.toggleAttribute('data-typing', true),
    onchange: ({ target }) => {
      target.removeAttribute('data-typing');
      set(parsed(target.value.trim(), type));
    },
  });
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

function fill(input, value) {
  if (input.hasAttribute('data-typing')) return;
  if (input.type === 'checkbox') input.checked = Boolean(value);
  else input.value = value === null ? '' : typeof value === 'object' ? JSON.stringify(value) : String(value);
}

function boundsText({ low, high, optional }) {
  const text = low === null ? '' : `${low} to ${high}`;
  return optional && text ? `${text}, or empty` : text;
}

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

function sliderOf(parameter, input, set) {
  const { name } = parameter;
  const scale = PHYSICAL.test(name) && sliderScale(parameter);
  if (!scale) return null;
  const slider = el('input', {
    type: 'range',
    ...scale.ends,
    'aria-label': `${name}, slider`,
    oninput: ({ target }) => fill(input, scale.valueAt(Number(target.value))),
    onchange: ({ target }) => set(scale.valueAt(Number(target.value))),
  });
  const show = (value) => {
    slider.value = String(scale.placeOf(value ?? 0));
    slider.setAttribute('aria-valuetext', String(value));
  };
  return { slider, show };
}
