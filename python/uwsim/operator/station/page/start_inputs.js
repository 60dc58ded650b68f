// The inputs of the start screen.
import { el } from './dom.js';

// A choice of { value, text, hint }.
export function options(choices) {
  const select = el('select');
  for (const { value, text, hint } of choices) {
    const option = el('option', { value: String(value) }, text);
    if (hint) option.dataset.hint = hint;
    select.append(option);
  }
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
