// The lamp that shows whether the flight is being recorded: red if it is not.
import { html } from '../vendor/preact.js';

export function recLamp({ state, description }) {
  const isOff = !state.flight;
  const why = isOff
    ? state.flight_trouble || 'This flight is not recorded'
    : `This flight is recorded as ${state.flight}`;
  return html`
    <span id="rec" class="rec ${isOff ? 'is-off' : ''}" role="status" title=${why} hidden=${!description?.is_recorded}>
      ${isOff ? 'NO REC' : 'REC'}
    </span>
  `;
}
