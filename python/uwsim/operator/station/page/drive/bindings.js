// The actions of keys, presets, and the pilot's own changes. A key is a place on the keyboard (KeyboardEvent.code).

// Axes are those of REP 103: x ahead, y to port, z up; so positive pitch is nose down and positive yaw turns to port.
export const DRIVING = {
  'surge+': 'Ahead',
  'surge-': 'Astern',
  'sway+': 'To port',
  'sway-': 'To starboard',
  'heave+': 'Up',
  'heave-': 'Down',
  'yaw+': 'Turn to port',
  'yaw-': 'Turn to starboard',
  'pitch+': 'Nose down',
  'pitch-': 'Nose up',
  'roll-': 'Roll to port',
  'roll+': 'Roll to starboard',
};
export const ALL_STOP = 'stop'; // acts even while a dialog is open
export const VEHICLE = {
  stop: 'All stop',
  zero: 'Efforts to zero',
  release: 'Release or dock',
  undock: 'Undock',
  drop: 'Let go of a marker or torpedo',
  frontOn: 'Front light on',
  frontOff: 'Front light off',
  downOn: 'Down light on',
  downOff: 'Down light off',
  front: 'Front light',
  down: 'Down light',
  tiltDown: 'Sonar nose down',
  tiltUp: 'Sonar nose up',
  gainUp: 'More gain',
  gainDown: 'Less gain',
  'hold.heading': 'Hold heading',
  'hold.depth': 'Hold depth',
  'hold.altitude': 'Hold altitude',
  'hold.position': 'Hold position',
  'hold.speed': 'Hold speed',
  gripClose: 'Close the jaws',
  gripOpen: 'Open the jaws',
  armNext: 'Next part of the arm',
  armBefore: 'Previous part of the arm',
  note: 'Add a note',
  camUp: 'Camera up',
  camDown: 'Camera down',
  camLeft: 'Camera to port',
  camRight: 'Camera to starboard',
};
export const SCREEN = {
  pause: 'Pause or resume',
  step: 'One step',
  snapshot: 'Snapshot',
  record: 'Record',
  comment: 'Comment in pictures',
  mute: 'Sound on or off',
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
  standard: { name: 'Standard', keys: STANDARD },
  published: { name: 'Published', addsUp: true, keys: { ...STANDARD, zero: ['KeyX'], stop: ['KeyC'] } },
  wasd: {
    // as in games: A and D turn
    name: 'WASD',
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
  Space: 'Space',
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
  PageUp: 'Page Up',
  PageDown: 'Page Down',
  Backquote: '`',
  ShiftLeft: 'Shift',
  ShiftRight: 'Right Shift',
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
    if (RESERVED.test(code)) return `${keyName(code)} is needed for something else`;
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
