// Bars from a middle line, for thrusters and efforts: values in [-1, 1], shown in percent.
import { el, write } from '../dom.js';

export class Bars {
  #rows = [];
  element = el('div', { className: 'bars' });

  name(names) {
    this.#rows = names.map(() => ({ fill: el('i'), value: el('output', {}, '–') }));
    this.element.replaceChildren(
      ...names.map((name, k) => {
        this.#rows[k].value.setAttribute('aria-label', name);
        return el(
          'div',
          { title: name.replaceAll('_', ' ') },
          this.#rows[k].value,
          el('div', { className: 'bar', 'aria-hidden': 'true' }, this.#rows[k].fill),
          el('span', { 'aria-hidden': 'true' }, shortened(name)),
        );
      }),
    );
  }

  show(values) {
    this.#rows.forEach(({ fill, value }, k) => {
      const part = Math.max(-1, Math.min(1, values[k] ?? 0));
      fill.style.top = `${50 - 50 * Math.max(part, 0)}%`;
      fill.style.height = `${50 * Math.abs(part)}%`;
      write(value, String(Math.round(100 * part)));
    });
  }
}

// A short name that fits below a bar: "vertical_front_left" becomes "v f l", "T3" stays.
function shortened(name) {
  const words = name.split('_');
  return words.length === 1 ? name.slice(0, 6) : words.map((word) => word.slice(0, words.length > 2 ? 1 : 2)).join('');
}
