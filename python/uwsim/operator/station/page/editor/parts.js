// The parts of the edited scenario, the chosen one, and what is not yet sent. The chart and the 3D view both show it.
import { turned } from './geometry.js';

const NOTCH_DEG = 5; // a notch of the wheel; with shift, a degree

// Events: 'pick' (detail: a part's index, or -1), 'done'
// (the change is to be sent), 'painted' (detail: the line of a stroke), 'change' (what is shown has changed).
export class EditedParts extends EventTarget {
  /** @type {import('../wire/messages.js').EditedPart[]} */
  list = [];
  selected = -1;
  /** @type {Record<string, any>} */
  changes = {}; // of the chosen part
  /** @type {[number, number] | null} */
  mark = null; // the point of the bed at which a part is added

  /** @type {import('../wire/messages.js').FormSection[]} */
  sections = []; // and their forms

  /** The fields of a part's kind.
   * @returns {import('../wire/messages.js').FormField[]}
   */
  fieldsOf({ section, kind }) {
    return this.sections.find(({ name }) => name === section)?.kinds.find((each) => each.kind === kind)?.fields ?? [];
  }

  titleOf(section) {
    return this.sections.find(({ name }) => name === section)?.title ?? section;
  }

  show(list, selected) {
    [this.list, this.selected] = [list, selected];
    this.#changed();
  }

  // The part at an index, with the changes that are not yet sent; undefined for -1, which no part has.
  at(index) {
    const part = this.list[index];
    return part && index === this.selected ? { ...part, values: { ...part.values, ...this.changes } } : part;
  }

  pick(index) {
    if (index !== this.selected) this.dispatchEvent(new CustomEvent('pick', { detail: index }));
  }

  // Mark a point of the bed, to 0.1 m; null for none.
  markAt(place) {
    this.mark = place && /** @type {[number, number]} */ (place.map((value) => Math.round(value * 10) / 10));
    this.#changed();
  }

  change(values) {
    this.changes = { ...this.changes, ...values };
    this.#changed();
  }

  // Turn the chosen part by a notch of the wheel.
  turn({ deltaX, deltaY, shiftKey }) {
    const way = deltaY < 0 || deltaX < 0 ? 1 : -1; // shift turns the wheel aside
    const part = this.at(this.selected);
    this.change(turned(part, this.fieldsOf(part), way * (shiftKey ? 1 : NOTCH_DEG)));
    this.done();
  }

  painted(line) {
    this.dispatchEvent(new CustomEvent('painted', { detail: line }));
  }

  done() {
    this.dispatchEvent(new Event('done'));
  }

  #changed() {
    this.dispatchEvent(new Event('change'));
  }
}
