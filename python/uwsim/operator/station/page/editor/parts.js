// The parts of the edited scenario, the chosen one, and what is not yet sent. The chart and the 3D view both show it.

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
