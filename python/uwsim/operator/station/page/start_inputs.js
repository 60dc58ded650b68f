// The inputs of the start screen.
import { el } from './dom.js';

// A choice of { value, text, hint, group }; those of a group, if there are any, stand below its name.
export function options(choices) {
  const select = el('select');
  /** @type {Map<string, Element>} */
  const groups = new Map();
  for (const { value, text, hint, group } of choices) {
    const option = el('option', { value: String(value) }, text);
    if (hint) option.dataset.hint = hint;
    if (group && !groups.has(group)) groups.set(group, el('optgroup', { label: group }));
    (groups.get(group) ?? select).append(option);
  }
  select.append(...groups.values());
  return select;
}

/** A number field that accepts any text: an invalid number is sent as it is, and the server reports the reason.
 * @param {{ min: number, max?: number, step: number }} bounds
 */
export function number({ min, max, step }) {
  return el('input', {
    type: 'text',
    inputMode: 'numeric',
    autocomplete: 'off',
    spellcheck: false,
    'data-min': min,
    'data-max': max,
    'data-step': step,
  });
}

export function address(placeholder) {
  return el('input', { type: 'text', autocomplete: 'off', spellcheck: false, placeholder });
}
