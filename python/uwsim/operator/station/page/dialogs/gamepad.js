// The gamepad dialog: live values, calibration, and the functions of sticks and buttons.
import { byId } from '../dom.js';
import { ACTIONS, DRIVING } from '../drive/bindings.js';
import { connectedPads } from '../drive/gamepad.js';
import { Calibration, DEAD_ZONES, readPad } from '../drive/pads.js';
import { html, signal } from '../vendor/preact.js';
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
export function showGamepads(gamepads) {
  const dialog = byId('gamepad-dialog');
  const index = connectedPads()[0]?.index;
  let step = null; // the pending calibration or assignment: step(pad) returns whether it is complete
  const levels = Object.fromEntries(AXES.map((effort) => [effort, signal('0')]));
  const pressed = []; // the classes of buttons
  const status = signal('');
  const finish = signal(null); // ends a calibration

  const pad = () => connectedPads().find((each) => each.index === index);
  const keep = (profile) => {
    gamepads.profiles.keep(pad(), profile);
    gamepads.disarm();
    step = finish.value = null;
    describe();
    again();
  };
  const change = (edit) => {
    const changed = structuredClone(gamepads.profiles.of(pad()));
    edit(changed);
    keep(changed);
  };
  const listen = (text, begin) => () => {
    step = begin(pad());
    status.value = text;
  };

  // end: the one that a trigger is assigned to; a stick has both.
  const assign = (effort, end, text) =>
    listen(`${text}: ${NAMES[effort]}.`, (from) => {
      const seen = new Calibration(from.axes);
      return (now) => {
        seen.add(now.axes);
        const pulled = now.buttons.findIndex(({ value }, k) => value > 0.6 && (from.buttons[k]?.value ?? 0) < 0.3);
        const moved = end === 'plus' && seen.moved;
        if (!moved && pulled < 0) return;
        change(({ sticks }) => {
          const { plus, minus } = sticks[effort] ?? {};
          sticks[effort] = moved || { plus, minus, [end]: pulled };
        });
      };
    });
  const calibrate = () => {
    const seen = new Calibration(pad()?.axes ?? []);
    step = (now) => seen.add(now.axes);
    status.value = 'Move every stick and trigger to all its limits, release them, then press Done.';
    finish.value = () => change((changed) => (changed.ranges = seen.ranges));
  };

  function row(effort) {
    const { sticks } = gamepads.profiles.of(pad());
    const { axis, sign, plus, minus } = sticks[effort] ?? {};
    const source =
      axis !== undefined
        ? `axis ${axis}${sign < 0 ? ', reversed' : ''}`
        : plus !== undefined || minus !== undefined
          ? `buttons ${plus ?? '–'} and ${minus ?? '–'}`
          : 'none';
    const remove = () => change(({ sticks: kept }) => delete kept[effort]);
    const button = (text, label, act) =>
      html`<button type="button" aria-label="${label}: ${NAMES[effort]}" onClick=${act}>${text}</button>`;
    return html`
      <div class="key-line">
        <span>${NAMES[effort]}: ${source}</span>
        <span class="row">
          <output class="reading" aria-label="${NAMES[effort]} now">${levels[effort]}</output>
          ${button('Assign', 'Assign', assign(effort, 'plus', 'Push the stick, or pull the trigger, for'))}
          ${
            axis === undefined &&
            plus !== undefined &&
            button('Opposite', 'Opposite', assign(effort, 'minus', 'Pull the trigger for the opposite of'))
          }
          ${sticks[effort] && button('✕', 'Remove', remove)}
        </span>
      </div>
    `;
  }

  function buttonRow(number) {
    const choose = ({ target }) =>
      change(({ buttons }) => {
        if (target.value) buttons[number] = target.value;
        else delete buttons[number];
      });
    return html`
      <div class="key-line">
        <span class=${(pressed[number] ??= signal(''))}>Button ${number}</span>
        <select aria-label="Button ${number}" value=${gamepads.profiles.of(pad()).buttons[number] ?? ''} onChange=${choose}>
          <option value="">nothing</option>
          ${COMMANDS.map((action) => html`<option value=${action}>${ACTIONS[action]}</option>`)}
        </select>
      </div>
    `;
  }

  function describe() {
    status.value =
      pad()?.mapping === 'standard'
        ? 'This gamepad has a standard layout.'
        : 'This gamepad has no standard layout: calibrate it, then assign its sticks and buttons.';
  }

  function view() {
    const now = pad();
    if (!now) return html`<p>Connect a gamepad, press one of its buttons, and reopen this dialog.</p>`;
    const isOwn = gamepads.profiles.isOwn(now);
    return html`
      <p>${now.id}</p>
      <p role="status">${status}</p>
      <div class="row">
        <button type="button" onClick=${calibrate}>Calibrate</button>
        <button type="button" hidden=${!finish.value} onClick=${finish.value}>Done</button>
        <button type="button" disabled=${!isOwn} onClick=${() => keep(null)}>Default</button>
        <label for="dead-zone">Dead zone</label>
        <input type="range" id="dead-zone" min=${DEAD_ZONES[0]} max=${DEAD_ZONES[1]} step="0.01"
          value=${gamepads.profiles.of(now).dead_zone}
          onChange=${({ target }) => change((changed) => (changed.dead_zone = Number(target.value)))} />
      </div>
      <h3>Sticks and triggers</h3>
      ${AXES.map(row)}
      <details><summary>Buttons</summary>${now.buttons.map((_, number) => buttonRow(number))}</details>
    `;
  }

  function look() {
    if (!dialog.open) return;
    const now = pad();
    if (now) {
      step?.(now);
      const { efforts } = readPad(now, gamepads.profiles.of(now));
      for (const effort of AXES) levels[effort].value = `${Math.round(100 * (efforts[effort] ?? 0))} %`;
      now.buttons.forEach(
        (each, number) => ((pressed[number] ??= signal('')).value = each.pressed ? 'is-pressed' : ''),
      );
    }
    requestAnimationFrame(look);
  }
  describe();
  const again = openDialog(dialog, 'Gamepad', view);
  requestAnimationFrame(look);
}
