// The actions of keys, presets, and the pilot's own changes. A key is a place on the keyboard (KeyboardEvent.code).
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.actions;

// Axes are those of REP 103: x ahead, y to port, z up; so positive pitch is nose down and positive yaw turns to port.
export const DRIVING = {
  'surge+': WORDS.ahead,
  'surge-': WORDS.astern,
  'sway+': WORDS.toPort,
  'sway-': WORDS.toStarboard,
  'heave+': WORDS.up,
  'heave-': WORDS.down,
  'yaw+': WORDS.turnToPort,
  'yaw-': WORDS.turnToStarboard,
  'pitch+': WORDS.noseDown,
  'pitch-': WORDS.noseUp,
  'roll-': WORDS.rollToPort,
  'roll+': WORDS.rollToStarboard,
};
export const ALL_STOP = 'stop'; // acts even while a dialog is open
export const VEHICLE = {
  stop: WORDS.allStop,
  zero: WORDS.effortsToZero,
  release: WORDS.releaseOrDock,
  undock: WORDS.undock,
  drop: WORDS.drop,
  frontOn: WORDS.frontLightOn,
  frontOff: WORDS.frontLightOff,
  downOn: WORDS.downLightOn,
  downOff: WORDS.downLightOff,
  front: WORDS.frontLight,
  down: WORDS.downLight,
  tiltDown: WORDS.sonarNoseDown,
  tiltUp: WORDS.sonarNoseUp,
  gainUp: WORDS.moreGain,
  gainDown: WORDS.lessGain,
  'hold.heading': WORDS.holdHeading,
  'hold.depth': WORDS.holdDepth,
  'hold.altitude': WORDS.holdAltitude,
  'hold.position': WORDS.holdPosition,
  'hold.speed': WORDS.holdSpeed,
  gripClose: WORDS.closeJaws,
  gripOpen: WORDS.openJaws,
  armNext: WORDS.nextPartOfArm,
  armBefore: WORDS.lastPartOfArm,
  note: WORDS.addANote,
  camUp: WORDS.cameraUp,
  camDown: WORDS.cameraDown,
  camLeft: WORDS.cameraToPort,
  camRight: WORDS.cameraToStarboard,
};
export const SCREEN = {
  pause: WORDS.pauseOrResume,
  step: WORDS.oneStep,
  snapshot: WORDS.snapshot,
  record: WORDS.record,
  comment: WORDS.commentInPictures,
  mute: WORDS.soundOnOrOff,
};
export const ACTIONS = { ...DRIVING, ...VEHICLE, ...SCREEN };

const SHARED = {
  'surge+': ['KeyW'],
  'surge-': ['KeyS'],
  stop: ['KeyX', 'KeyC'],
  release: ['KeyR'],
  undock: ['KeyY'],
  drop: ['Delete'],
  frontOff: ['BracketLeft'],
  frontOn: ['BracketRight'],
  downOff: ['Semicolon'],
  downOn: ['Quote'],
  tiltDown: ['Comma'],
  tiltUp: ['Period'],
  gainUp: ['Equal'],
  gainDown: ['Minus'],
  'hold.heading': ['KeyH'],
  'hold.depth': ['KeyZ'],
  'hold.altitude': ['KeyT'],
  'hold.position': ['KeyO'],
  'hold.speed': ['KeyF'],
  note: ['KeyM'],
  gripClose: ['PageDown'],
  gripOpen: ['PageUp'],
  armNext: ['Backslash'],
  armBefore: ['Backspace'],
  pause: ['KeyP'],
  step: ['KeyN'],
  snapshot: ['KeyV'],
  record: ['KeyG'],
  comment: ['Backquote'],
  mute: ['KeyU'],
};
// The keys of the paper's keyboard node.
const STANDARD = {
  ...SHARED,
  'sway+': ['KeyA'],
  'sway-': ['KeyD'],
  'heave+': ['Space'],
  'heave-': ['KeyB'],
  'yaw+': ['KeyQ'],
  'yaw-': ['KeyE'],
  'pitch+': ['KeyI'],
  'pitch-': ['KeyK'],
  'roll-': ['KeyJ'],
  'roll+': ['KeyL'],
  camUp: ['ArrowUp'],
  camDown: ['ArrowDown'],
  camLeft: ['ArrowLeft'],
  camRight: ['ArrowRight'],
};
// addsUp: whether each press adds to its axis or subtracts, and the sum lasts. Otherwise a key acts while it is held.
export const PRESETS = {
  standard: { name: WORDS.standard, keys: STANDARD },
  published: { name: WORDS.published, addsUp: true, keys: { ...STANDARD, zero: ['KeyX'], stop: ['KeyC'] } },
  wasd: {
    // as in games: A and D turn
    name: WORDS.wasd,
    keys: {
      ...SHARED,
      'yaw+': ['KeyA'],
      'yaw-': ['KeyD'],
      'sway+': ['KeyQ'],
      'sway-': ['KeyE'],
      'heave+': ['Space'],
      'heave-': ['ShiftLeft'],
      'pitch+': ['ArrowUp'],
      'pitch-': ['ArrowDown'],
      'roll-': ['ArrowLeft'],
      'roll+': ['ArrowRight'],
      camUp: ['KeyI'],
      camDown: ['KeyK'],
      camLeft: ['KeyJ'],
      camRight: ['KeyL'],
    },
  },
};

const RESERVED = /^(Digit\d|Escape|Tab|Enter|F\d+|Slash|Meta.*|Control.*|Alt.*)$/;
const STORED = 'uwsim.keys';
const NAMES = {
  Space: WORDS.space,
  BracketLeft: '[',
  BracketRight: ']',
  Semicolon: ';',
  Quote: "'",
  Comma: ',',
  Period: '.',
  Equal: '=',
  Minus: '-',
  Slash: '/',
  Backslash: '\\',
  Backspace: '⌫',
  PageUp: WORDS.pageUp,
  PageDown: WORDS.pageDown,
  Backquote: '`',
  ShiftLeft: WORDS.shift,
  ShiftRight: WORDS.rightShift,
  ArrowUp: '↑',
  ArrowDown: '↓',
  ArrowLeft: '←',
  ArrowRight: '→',
};

export const keyName = (code) => NAMES[code] ?? code.replace(/^(Key|Digit)/, '');

export class Bindings {
  #actionOf = new Map();

  constructor() {
    const kept = readStored();
    this.preset = kept.preset in PRESETS ? kept.preset : 'standard';
    this.changes = kept.changes ?? {};
    this.#index();
  }

  get addsUp() {
    return Boolean(PRESETS[this.preset].addsUp);
  }

  get isChanged() {
    return Object.keys(this.changes).length > 0;
  }

  actionOf(code) {
    return this.#actionOf.get(code);
  }

  keysOf(action) {
    return this.changes[action] ?? PRESETS[this.preset].keys[action] ?? [];
  }

  choose(preset) {
    this.preset = preset;
    this.changes = {};
    this.#keep();
  }

  // Bind a key to an action and unbind its previous action. Return the reason if this is impossible, else ''.
  assign(action, code) {
    if (RESERVED.test(code)) return WORDS.isNeeded(keyName(code));
    const owner = this.actionOf(code);
    if (owner && owner !== action) this.changes[owner] = this.keysOf(owner).filter((key) => key !== code);
    this.changes[action] = [code];
    this.#keep();
    return '';
  }

  #keep() {
    this.#index();
    try {
      localStorage.setItem(STORED, JSON.stringify({ preset: this.preset, changes: this.changes }));
    } catch {
      /* this browser stores nothing: the keys last until the page is closed */
    }
  }

  #index() {
    this.#actionOf.clear();
    for (const action of Object.keys(ACTIONS)) for (const code of this.keysOf(action)) this.#actionOf.set(code, action);
  }
}

function readStored() {
  try {
    return JSON.parse(localStorage.getItem(STORED) ?? '{}');
  } catch {
    return {};
  }
}
