// The gamepad dialog: live values, calibration, and the functions of sticks and buttons.
import { byId, el, write } from '../dom.js';
import { ACTIONS, DRIVING } from '../drive/bindings.js';
import { connectedPads } from '../drive/gamepad.js';
import { Calibration, DEAD_ZONES, readPad } from '../drive/pads.js';
import { AXES } from '../wire/messages.js';
import { openDialog } from './dialog.js';

const NAMES = {
  surge: 'Ahead',
  sway: 'To port',
  heave: 'Up',
  roll: 'Roll to starboard',
  pitch: 'Nose down',
  yaw: 'Turn to port',
};
const COMMANDS = Object.keys(ACTIONS).filter((action) => !(action in DRIVING));
const button = (text, onclick, attributes = {}) => el('button', { type: 'button', onclick, ...attributes }, text);

export function showGamepads(gamepads) {
  const dialog = byId('gamepad-dialog');
  const index = connectedPads()[0]?.index;
  let step = null; // the pending calibration or assignment: step(pad) returns whether it is complete
  let outputs = [];

  const pad = () => connectedPads().find((each) => each.index === index);
  const status = el('p', { role: 'status' }, '');
  const keep = (profile) => {
    gamepads.profiles.keep(pad(), profile);
    gamepads.disarm();
    step = null;
    render();
  };
  const profile = () => structuredClone(gamepads.profiles.of(pad()));
  const listen = (text, begin) => () => {
    step = begin(pad());
    write(status, text);
  };

  const assign = (effort) =>
    listen(`Push the stick, or pull the trigger, for: ${NAMES[effort]}.`, (from) => {
      const seen = new Calibration(from.axes);
      return (now) => {
        seen.add(now.axes);
        const pulled = now.buttons.findIndex(({ value }, k) => value > 0.6 && (from.buttons[k]?.value ?? 0) < 0.3);
        if (!seen.moved && pulled < 0) return;
        const changed = profile();
        if (seen.moved) changed.sticks[effort] = seen.moved;
        else changed.sticks[effort] = { minus: changed.sticks[effort]?.minus, plus: pulled };
        keep(changed);
      };
    });
  const assignOpposite = (effort) =>
    listen(`Pull the trigger for the opposite of: ${NAMES[effort]}.`, () => (now) => {
      const pulled = now.buttons.findIndex(({ value }) => value > 0.6);
      if (pulled < 0) return;
      const changed = profile();
      changed.sticks[effort] = { plus: changed.sticks[effort]?.plus, minus: pulled };
      keep(changed);
    });
  const calibrate = () => {
    const seen = new Calibration(pad()?.axes ?? []);
    step = (now) => seen.add(now.axes);
    write(status, 'Move every stick and trigger to all its limits, release them, then press Done.');
    done.hidden = false;
    done.onclick = () => keep({ ...profile(), ranges: seen.ranges });
  };
  const done = button('Done', null, { hidden: true });

  function row(effort) {
    const { sticks } = gamepads.profiles.of(pad());
    const { axis, sign, plus, minus } = sticks[effort] ?? {};
    const source =
      axis !== undefined
        ? `axis ${axis}${sign < 0 ? ', reversed' : ''}`
        : plus !== undefined || minus !== undefined
          ? `buttons ${plus ?? '–'} and ${minus ?? '–'}`
          : 'none';
    const meter = el('output', { className: 'reading', 'aria-label': `${NAMES[effort]} now` }, '0');
    outputs.push([effort, meter]);
    return el(
      'div',
      { className: 'key-line' },
      el('span', {}, `${NAMES[effort]}: ${source}`),
      el(
        'span',
        { className: 'row' },
        meter,
        button('Assign', assign(effort), { 'aria-label': `Assign: ${NAMES[effort]}` }),
        axis === undefined && plus !== undefined
          ? button('Opposite', assignOpposite(effort), { 'aria-label': `Opposite: ${NAMES[effort]}` })
          : null,
        sticks[effort] &&
          button(
            '✕',
            () => {
              const changed = profile();
              delete changed.sticks[effort];
              keep(changed);
            },
            { 'aria-label': `Remove: ${NAMES[effort]}` },
          ),
      ),
    );
  }

  function buttonRow(number) {
    const chosen = gamepads.profiles.of(pad()).buttons[number] ?? '';
    const select = el(
      'select',
      { 'aria-label': `Button ${number}` },
      el('option', { value: '' }, 'nothing'),
      ...COMMANDS.map((action) => el('option', { value: action, selected: action === chosen }, ACTIONS[action])),
    );
    select.addEventListener('change', () => {
      const changed = profile();
      if (select.value) changed.buttons[number] = select.value;
      else delete changed.buttons[number];
      keep(changed);
    });
    const lamp = el('span', {}, `Button ${number}`);
    outputs.push([number, lamp]);
    return el('div', { className: 'key-line' }, lamp, select);
  }

  function render() {
    const now = pad();
    outputs = [];
    if (!now) {
      openDialog(
        dialog,
        'Gamepad',
        el('p', {}, 'Connect a gamepad, press one of its buttons, and reopen this dialog.'),
      );
      return;
    }
    const { dead_zone } = gamepads.profiles.of(now);
    const zone = el('input', {
      type: 'range',
      id: 'dead-zone',
      min: DEAD_ZONES[0],
      max: DEAD_ZONES[1],
      step: 0.01,
      value: dead_zone,
    });
    zone.addEventListener('change', () => keep({ ...profile(), dead_zone: Number(zone.value) }));
    done.hidden = true;
    write(
      status,
      now.mapping === 'standard'
        ? 'This gamepad has a standard layout.'
        : 'This gamepad has no standard layout: calibrate it, then assign its sticks and buttons.',
    );
    openDialog(
      dialog,
      'Gamepad',
      el('p', {}, now.id),
      status,
      el(
        'div',
        { className: 'row' },
        button('Calibrate', calibrate),
        done,
        button('Default', () => keep(null), { disabled: !gamepads.profiles.isOwn(now) }),
        el('label', { htmlFor: 'dead-zone' }, 'Dead zone'),
        zone,
      ),
      el('h3', {}, 'Sticks and triggers'),
      ...AXES.map(row),
      el('details', {}, el('summary', {}, 'Buttons'), ...now.buttons.map((_, number) => buttonRow(number))),
    );
  }

  function look() {
    if (!dialog.open) return;
    const now = pad();
    if (now) {
      step?.(now);
      const { efforts } = readPad(now, gamepads.profiles.of(now));
      for (const [name, output] of outputs)
        if (typeof name === 'string') write(output, `${Math.round(100 * (efforts[name] ?? 0))} %`);
        else output.classList.toggle('is-pressed', Boolean(now.buttons[name]?.pressed));
    }
    requestAnimationFrame(look);
  }
  render();
  requestAnimationFrame(look);
}
