// The faults of a run on a time line: a bar for each, from its start to its end, with its size; the present is a line.
import { clockText, el } from './dom.js';
import { STRINGS } from './strings.js';

const WORDS = STRINGS.instructor;
const LEAST_S = 60; // shown
const AHEAD_S = 30; // after the present and the last planned end

/** The times at both ends of the line [s].
 * @type {(faults: import('./wire/messages.js').FaultTime[], now_s: number) => [number, number]}
 */
export function span(faults, now_s) {
  const ends = faults.map(({ begin_s, end_s, planned_end_s }) => end_s ?? planned_end_s ?? begin_s);
  const last = Math.max(now_s, ...ends) + AHEAD_S;
  return [Math.max(0, Math.min(now_s - LEAST_S, ...faults.map(({ begin_s }) => begin_s))), last];
}

export class FaultTimes {
  element = el('ol', { className: 'fault-times', 'aria-label': WORDS.timeLine });
  #shown = '';

  show(faults, now_s) {
    const [first, last] = span(faults, now_s);
    const share = (time_s) => (100 * (time_s - first)) / (last - first);
    const shown = JSON.stringify([faults, Math.round(now_s)]);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.element.replaceChildren(
      ...faults.map(({ name, size, begin_s, end_s, planned_end_s }) => {
        const end = end_s ?? planned_end_s;
        const bar = el('i');
        bar.style.left = `${share(begin_s)}%`;
        bar.style.width = `${Math.max(share(end ?? last) - share(begin_s), 0.5)}%`;
        const now = el('b');
        now.style.left = `${share(now_s)}%`;
        bar.className = begin_s > now_s ? 'is-planned' : end_s === null ? 'is-active' : '';
        const text = `${name} ${clockText(begin_s, 1)} – ${end === null ? '…' : clockText(end, 1)} ${size}`;
        return el('li', {}, el('span', {}, text), el('div', { 'aria-hidden': 'true' }, bar, now));
      }),
    );
  }
}
