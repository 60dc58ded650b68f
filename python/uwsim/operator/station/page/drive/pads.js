// Converts a gamepad's axes and buttons to efforts and actions, according to a profile stored for each kind of pad.

const STORED = 'uwsim.pads';
export const DEAD_ZONE = 0.12;
export const DEAD_ZONES = [0.02, 0.5];
const FULL = { rest: 0, low: -1, high: 1 };
const CURVE = 1.5; // fine control near the middle, full effort at the end

// The mapping `standard` of https://www.w3.org/TR/gamepad. The sticks work as on most ROVs: the left one climbs and
// turns, the right one moves ahead and sideways.
const STANDARD = {
  sticks: {
    yaw: { axis: 0, sign: -1 },
    heave: { axis: 1, sign: -1 },
    sway: { axis: 2, sign: -1 },
    surge: { axis: 3, sign: -1 },
  },
  buttons: {
    0: 'stop',
    1: 'note',
    2: 'front',
    3: 'down',
    4: 'gainDown',
    5: 'gainUp',
    6: 'gripOpen',
    7: 'gripClose',
    8: 'pause',
    9: 'release',
    10: 'hold.heading',
    11: 'hold.depth',
    12: 'tiltUp',
    13: 'tiltDown',
    14: 'armBefore',
    15: 'armNext',
  },
};

// A profile: sticks, by effort: { axis, sign }, or { plus, minus }, two buttons such as triggers; buttons: number to
// action; ranges: rest, low and high of each calibrated axis; dead_zone. A pad whose mapping is unknown has no sticks:
// its axes may be anything, and some rest at their ends.
export function defaultProfile({ mapping }) {
  const { sticks, buttons } = mapping === 'standard' ? STANDARD : { sticks: {}, buttons: {} };
  return { sticks: { ...sticks }, buttons: { ...buttons }, ranges: {}, dead_zone: DEAD_ZONE };
}

// Scale a value from its axis's range to [-1, 1], with 0 at rest and in the dead zone around it.
export function shaped(value, { rest, low, high } = FULL, dead_zone = DEAD_ZONE) {
  if (!Number.isFinite(value)) return 0;
  const reach = value < rest ? rest - low : high - rest;
  const share = reach > 0 ? (value - rest) / reach : 0;
  const size = Math.min(Math.abs(share), 1);
  return size < dead_zone ? 0 : Math.sign(share) * ((size - dead_zone) / (1 - dead_zone)) ** CURVE;
}

// Return the efforts and the pressed actions of a pad.
export function readPad({ axes, buttons }, profile) {
  const efforts = {};
  const pull = (number) => shaped(buttons[number]?.value ?? 0, FULL, profile.dead_zone);
  for (const [effort, { axis, sign, plus, minus }] of Object.entries(profile.sticks))
    efforts[effort] =
      axis === undefined
        ? pull(plus) - pull(minus)
        : sign * shaped(axes[axis], profile.ranges[axis] ?? FULL, profile.dead_zone) || 0;
  const actions = new Set();
  buttons.forEach(({ pressed }, number) => {
    if (pressed && profile.buttons[number]) actions.add(profile.buttons[number]);
  });
  return { efforts, actions };
}

// A pad may drive only after all its sticks have been at rest since it was connected or the pilot took the controls.
export class Arming {
  #centred = 0;

  get isArmed() {
    return this.#centred >= Arming.LOOKS;
  }

  static LOOKS = 5; // consecutive frames at rest

  // Process the efforts of one frame; return those that may take effect.
  pass(efforts, isAllowed) {
    const values = Object.values(efforts); // empty for a pad without sticks, which is unknown, not at rest
    const isCentred = values.length > 0 && values.every((effort) => effort === 0);
    if (!isAllowed) this.#centred = 0;
    else if (!this.isArmed) this.#centred = isCentred ? this.#centred + 1 : 0;
    return this.isArmed ? efforts : Object.fromEntries(Object.keys(efforts).map((effort) => [effort, 0]));
  }

  disarm() {
    this.#centred = 0;
  }
}

// Learns the rest positions, ranges and identities of axes from their motion.
export class Calibration {
  #ranges;

  // axes: their values while the sticks are at rest.
  constructor(axes) {
    this.#ranges = axes.map((rest) => ({ rest, low: rest, high: rest }));
  }

  add(axes) {
    axes.forEach((value, k) => {
      const range = this.#ranges[k];
      if (!range || !Number.isFinite(value)) return;
      [range.low, range.high] = [Math.min(range.low, value), Math.max(range.high, value)];
    });
  }

  // The ranges of the axes that were moved, by number. If an axis moves to one side only, such as a trigger, its range
  // ends at rest. If a stick was moved only a little to one side, that side gets half the length of the other.
  get ranges() {
    const moved = this.#ranges.map((range, k) => [k, range]).filter(([, { low, high }]) => high - low > 0.2);
    return Object.fromEntries(
      moved.map(([k, { rest, low, high }]) => {
        const isOneSided = Math.min(rest - low, high - rest) < 0.05;
        const reach = Math.max(rest - low, high - rest);
        return [
          k,
          isOneSided
            ? { rest, low, high }
            : { rest, low: Math.min(low, rest - 0.5 * reach), high: Math.max(high, rest + 0.5 * reach) },
        ];
      }),
    );
  }

  // The axis that has moved farthest and the sign of its motion, or null.
  get moved() {
    let found = null;
    for (const [axis, { rest, low, high }] of this.#ranges.entries()) {
      const far = Math.max(rest - low, high - rest);
      if (far > (found?.far ?? 0.4)) found = { axis, sign: high - rest >= rest - low ? 1 : -1, far };
    }
    return found && { axis: found.axis, sign: found.sign };
  }
}

// The pilot's own profiles, by the pads' names.
export class Profiles {
  #kept;

  constructor(storage = globalThis.localStorage) {
    this.storage = storage;
    try {
      this.#kept = JSON.parse(storage.getItem(STORED) ?? '{}');
    } catch {
      this.#kept = {};
    }
  }

  of(pad) {
    return this.#kept[pad.id] ?? defaultProfile(pad);
  }

  isOwn({ id }) {
    return id in this.#kept;
  }

  // Store a profile; null restores the pad's default.
  keep({ id }, profile) {
    if (profile) this.#kept[id] = profile;
    else delete this.#kept[id];
    try {
      this.storage.setItem(STORED, JSON.stringify(this.#kept));
    } catch {
      /* this browser stores nothing: the profile lasts until the page is closed */
    }
  }
}
