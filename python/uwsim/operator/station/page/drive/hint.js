// States, where driving keys are pressed, why they move nothing.
import { ALL_STOPPED } from '../wire/messages.js';
import { byId, capital, write } from '../dom.js';
import { keyName } from './bindings.js';

const LEAST_MS = 1500; // that a hint stays, so that a tapped key has one, too

// Show the reason from now on, whenever a driving key is held and moves nothing.
export function explainIdleKeys(station, telemetry, pilot, bindings) {
  let timer = 0;
  const look = () => {
    if (!pilot.isHeld || !station.isRunning) return;
    const text = reason(station, telemetry.message, bindings);
    clearTimeout(timer);
    show(text);
    if (text) timer = setTimeout(show, LEAST_MS, '');
  };
  pilot.addEventListener('efforts', look);
  telemetry.addEventListener('change', look);
  station.addEventListener('state', look);
}

function show(text) {
  write(byId('hint'), text);
  byId('hint').hidden = text === '';
}

// Why a driving key moves nothing; '' if it moves the vehicle.
export function reason(station, message, bindings) {
  const { state } = station;
  if (station.isBlind) return 'Your keys do nothing: nothing arrives from the simulator.';
  if (!station.isPilot) {
    if (state.pilot !== '') return `Your keys do nothing: ${station.nameOf(state.pilot)} flies.`;
    return `Your keys do nothing: ${state.driver ? `${capital(state.driver)} drives` : 'you do not have the controls'}.`;
  }
  if (message?.alarms?.includes(ALL_STOPPED)) return 'Your keys do nothing: all stop is set.';
  if (state.paused) return 'Your keys do nothing: time stands still.';
  const [key] = bindings.keysOf('release').map(keyName);
  if (message?.released === false)
    return `Docked, so the thrusters are off: release the vehicle first${key ? ` (${key})` : ''}.`;
  return message?.battery === 0 ? 'The battery is empty: the thrusters are off.' : '';
}
