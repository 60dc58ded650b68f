// The form with which the instructor lets a part of the vehicle fail: a kind of fault, and an input for each of its keys.
import { el, tip } from './dom.js';
import { STRINGS } from './strings.js';

const WORDS = STRINGS.instructor;

export class FaultForm {
  #kinds = [];
  #vehicles = [];
  #inputs = new Map(); // key: its input, and a function of the input's text that returns the value

  // inject: called with the arguments of the command `inject_fault`.
  constructor(inject) {
    this.kind = el('select', { 'aria-label': WORDS.fault, onchange: () => this.#show() });
    this.fields = el('div', { className: 'instructor-row' });
    this.vehicle = el('select', { 'aria-label': STRINGS.editor.vehicle, onchange: () => this.#show() });
    const add = el('button', { type: 'button', onclick: () => inject(this.#arguments()) }, WORDS.add);
    this.element = el('div', {}, el('div', { className: 'instructor-row' }, this.kind, this.vehicle, add), this.fields);
  }

  // kinds: as listed by the service `fault_kinds`. vehicles: their truth, with the names of their parts.
  offer(kinds, vehicles) {
    [this.#kinds, this.#vehicles] = [kinds, vehicles];
    this.vehicle.replaceChildren(...vehicles.map(({ name }) => el('option', { value: name }, name)));
    this.vehicle.hidden = vehicles.length < 2;
    this.kind.replaceChildren(...kinds.map(({ kind }) => el('option', { value: kind }, WORDS.kinds[kind] ?? kind)));
    this.#show();
  }

  #show() {
    const chosen = this.#kinds.find(({ kind }) => kind === this.kind.value);
    tip(this.kind, chosen?.meaning ?? '');
    const fields = chosen?.fields ?? [];
    this.#inputs = new Map(fields.map((field) => [field.name, this.#input(field)]));
    const start = {
      name: 'in_s',
      value: 0,
      is_number: true,
      width: 1,
      low: 0,
      high: 1e6,
      choices: [],
      is_optional: true,
    };
    this.#inputs.set('in_s', this.#input(start));
    this.fields.replaceChildren(
      el('label', { className: 'instructor-field' }, WORDS.inSeconds, this.#inputs.get('in_s').input),
      ...fields.map(({ name, unit, meaning }) =>
        el('label', { className: 'instructor-field', tip: meaning }, name, this.#inputs.get(name).input, unit),
      ),
    );
  }

  #input(field) {
    const vehicle = this.#vehicles.find(({ name }) => name === this.vehicle.value);
    const choices = (field.part && vehicle?.[field.part]) || field.choices;
    if (choices.length > 0) return choice(field, choices);
    const bounds = field.low === null ? '' : `${field.low} … ${field.high}`;
    const input = el('input', {
      type: 'text',
      autocomplete: 'off',
      spellcheck: false,
      placeholder: bounds,
      value: [field.value ?? ''].flat().join(', '),
      'aria-label': field.name,
    });
    return { input, read: (text) => read(field, text) };
  }

  // An empty input keeps the default.
  #arguments() {
    const given = [...this.#inputs].filter(([, { input }]) => input.value.trim() !== '');
    const values = given.map(([name, { input, read: valueOf }]) => [name, valueOf(input.value)]);
    return { kind: this.kind.value, vehicle: this.vehicle.value, ...Object.fromEntries(values) };
  }
}

function choice(field, choices) {
  const offered = field.is_optional && field.value === null ? ['', ...choices] : choices;
  const input = el(
    'select',
    { 'aria-label': field.name },
    ...offered.map((value) => el('option', { value: String(value) }, String(value))),
  );
  if (field.value !== null) input.value = String(field.value);
  return { input, read: (text) => choices.find((value) => String(value) === text) };
}

// Text that is no number is sent as it is: the simulator refuses it, with the reason.
function read({ is_number, width }, text) {
  const number = (part) => (is_number && !Number.isNaN(Number(part)) ? Number(part) : part.trim());
  return width > 1 ? text.split(',').map(number) : number(text);
}
