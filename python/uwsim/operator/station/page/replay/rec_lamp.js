// The lamp that shows whether the flight is being recorded: red if it is not.
import { byId, tip, write } from '../dom.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.flights;

export function showRecording(station) {
  for (const event of ['state', 'description']) station.addEventListener(event, () => show(station));
}

function show({ state, description }) {
  const lamp = byId('rec');
  const isOff = !state.flight;
  lamp.hidden = !description?.is_recorded;
  lamp.classList.toggle('is-off', isOff);
  write(lamp, isOff ? WORDS.notRecorded : WORDS.recorded);
  tip(lamp, isOff ? state.flight_trouble || WORDS.nothingRecorded : WORDS.recordedAs(state.flight));
}
