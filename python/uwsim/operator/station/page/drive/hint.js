// Explains, while driving keys are pressed, why they have no effect.
import { ALL_STOPPED } from '../wire/messages.js';
import { byId, write } from '../dom.js';
import { keyName } from './bindings.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.idleKeys;

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
  if (station.isBlind) return WORDS.silence;
  if (station.description?.replay) return STRINGS.replay.idleKeys;
  if (!station.isPilot) {
    if (state.pilot !== '') return WORDS.otherFlies(station.nameOf(state.pilot));
    return state.driver ? WORDS.driven(state.driver) : WORDS.noHelm;
  }
  if (message?.alarms?.includes(ALL_STOPPED)) return WORDS.allStop;
  if (state.paused) return station.awaitsBegin ? WORDS.notBegun : WORDS.paused;
  const [key] = bindings.keysOf('release').map(keyName);
  if (message?.released === false) return WORDS.docked(key);
  return message?.battery === 0 ? WORDS.empty : '';
}
