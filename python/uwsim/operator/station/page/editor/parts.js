// The parts of the edited scenario, the chosen one, and what is not yet sent. The chart and the 3D view both show it.
import { capital } from '../dom.js';

/** @type {Record<string, string>} */
const SECTIONS = {
  cover: 'Cover and growth',
  exercise_start: 'Start in the exercise',
  layout: 'Props moved by the seed',
  life: 'Fish',
  objects: 'Loose bodies',
  optics: 'Light',
  starts: 'Start',
  strokes: 'Drawn on the bed',
  surface: 'Waves',
  terrain: 'Bed',
};

/** What a section of the scenario is called, by its name in the file.
 * @type {(section: string) => string}
 */
export const sectionName = (section) => SECTIONS[section] ?? capital(section.replaceAll('_', ' '));

// Events: 'pick' (detail: a part's index, or -1), 'draft' (detail: values of the chosen part while they change), 'done'
// (the change is to be sent), 'painted' (detail: the line of a stroke), 'change' (what is shown has changed).
export class EditedParts extends EventTarget {
  /** @type {import('../wire/messages.js').EditedPart[]} */
  list = [];
  selected = -1;
  /** @type {Record<string, any>} */
  changes = {}; // of the chosen part
  /** @type {[number, number] | null} */
  mark = null; // the point of the bed at which a part is added

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
    this.dispatchEvent(new CustomEvent('draft', { detail: values }));
    this.#changed();
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
