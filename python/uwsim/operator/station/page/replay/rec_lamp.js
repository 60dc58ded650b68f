// The lamp that shows whether the flight is being recorded: red if it is not.
import { byId, write } from '../dom.js';

export function showRecording(station) {
  for (const event of ['state', 'description']) station.addEventListener(event, () => show(station));
}

function show({ state, description }) {
  const lamp = byId('rec');
  const isOff = !state.flight;
  lamp.hidden = !description?.is_recorded;
  lamp.classList.toggle('is-off', isOff);
  write(lamp, isOff ? 'NO REC' : 'REC');
  lamp.title = isOff
    ? state.flight_trouble || 'This flight is not recorded'
    : `This flight is recorded as ${state.flight}`;
}
