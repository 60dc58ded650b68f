// Bars from a middle line, for thrusters and efforts: values in [-1, 1], shown in percent.
import { html } from '../vendor/preact.js';

export const bars = (names, values) =>
  html`<div class="bars">${names.map((name, k) => bar(name, Math.max(-1, Math.min(1, values[k] ?? 0))))}</div>`;

const bar = (name, part) => html`
  <div title=${name.replaceAll('_', ' ')}>
    <output aria-label=${name}>${Math.round(100 * part)}</output>
    <div class="bar" aria-hidden="true">
      <i style=${{ top: `${50 - 50 * Math.max(part, 0)}%`, height: `${50 * Math.abs(part)}%` }} />
    </div>
    <span aria-hidden="true">${shortened(name)}</span>
  </div>
`;

// A short name that fits below a bar: "vertical_front_left" becomes "v f l", "T3" stays.
function shortened(name) {
  const words = name.split('_');
  return words.length === 1 ? name.slice(0, 6) : words.map((word) => word.slice(0, words.length > 2 ? 1 : 2)).join('');
}
