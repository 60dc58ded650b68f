// Explains, while driving keys are pressed, why they have no effect.
import { ALL_STOPPED } from '../wire/messages.js';
import { byId, write } from '../dom.js';
import { keyName } from './bindings.js';

const LEAST_MS = 1500; // minimum duration of a hint, so that it can be read after a tap

// Start showing the reason whenever a driving key is held without effect.
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

// The reason why a driving key has no effect; '' if it moves the vehicle.
export function reason(station, message, bindings) {
  const { state } = station;
  if (station.isBlind) return 'Your keys do nothing: no data arrive from the simulator.';
  if (station.description?.replay) return 'Your keys do nothing: this is a replay. Take the helm to fly.';
  if (!station.isPilot) {
    if (state.pilot !== '') return `Your keys do nothing: ${station.nameOf(state.pilot)} is flying.`;
    return state.driver
      ? `Your keys do nothing: ${state.driver} is driving.`
      : 'Your keys do nothing: you do not have the controls.';
  }
  if (message?.alarms?.includes(ALL_STOPPED)) return 'Your keys do nothing: all stop is set.';
  if (state.paused)
    return station.awaitsBegin
      ? 'Your keys do nothing: press Begin in the panel, or Enter.'
      : 'Your keys do nothing: the simulation is paused.';
  const [key] = bindings.keysOf('release').map(keyName);
  if (message?.released === false)
    return `Docked, so the thrusters are off: release the vehicle first${key ? ` (${key})` : ''}.`;
  return message?.battery === 0 ? 'The battery is empty: the thrusters are off.' : '';
}
