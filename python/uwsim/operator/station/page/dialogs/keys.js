// The list of keys, which ? opens; a click on an action and a key press change its key.
import { byId } from '../dom.js';
import { ACTIONS, DRIVING, keyName, PRESETS, SCREEN, VEHICLE } from '../drive/bindings.js';
import { html, signal } from '../vendor/preact.js';
import { openDialog } from './dialog.js';

const ASK = 'Click an action, then press its new key.';
const OTHERS = [
  ['?', 'These keys'],
  ['Enter', 'Begin the exercise'],
  ['Esc', 'Menu'],
];
const GAMEPAD = [
  ['left stick', 'Up, down, turn'],
  ['right stick', 'Ahead, sideways'],
  ['A', 'All stop'],
  ['LB RB', 'Gain'],
  ['↑ ↓', 'Sonar tilt'],
  ['X Y', 'Front light, down light'],
  ['← →', 'Part of the arm'],
  ['LT RT', 'Open, close the jaws'],
  ['Start', 'Release or dock'],
  ['stick presses', 'Hold heading, depth'],
];

const fixedLine = ([key, text]) => html`<div class="key-line"><span>${text}</span><kbd>${key}</kbd></div>`;
const block = (title, ...contents) => html`<section><h3>${title}</h3>${contents}</section>`;

// views: see Views.keyed.
export function showKeys(bindings, views) {
  const message = signal(ASK);
  const changing = signal(''); // the action whose key is to be pressed

  const take = (event) => {
    event.preventDefault();
    event.stopPropagation();
    const refusal = event.code === 'Escape' ? '' : bindings.assign(changing.value, event.code);
    listen('');
    message.value = refusal || ASK;
  };
  const listen = (action) => {
    changing.value = action;
    if (action) addEventListener('keydown', take, true);
    else removeEventListener('keydown', take, true);
  };
  const line = (action) => {
    const keys = bindings.keysOf(action).map(keyName);
    const isChanging = changing.value === action;
    const shown = keys.length ? keys.map((key, k) => [k ? ' ' : '', html`<kbd>${key}</kbd>`]) : html`<span>none</span>`;
    return html`
      <div class="key-line">
        <span>${ACTIONS[action]}</span>
        <button type="button" aria-pressed=${isChanging} onClick=${() => listen(action)}
          aria-label="${ACTIONS[action]}: ${keys.join(' ') || 'none'}; change">
          ${isChanging ? 'Press a key' : shown}
        </button>
      </div>
    `;
  };
  const lines = (actions) => Object.keys(actions).map(line);
  const preset = ([name, { name: title }]) => {
    const choose = () => {
      bindings.choose(name);
      again();
    };
    const isChosen = bindings.preset === name && !bindings.isChanged;
    return html`<button type="button" aria-pressed=${isChosen} onClick=${choose}>${title}</button>`;
  };
  const view = () => html`
    <div class="row apart">
      <div class="row" role="group" aria-label="Preset">
        ${Object.entries(PRESETS).map(preset)}
        ${bindings.isChanged && html`<span class="caption">changed</span>`}
        ${bindings.addsUp && html`<span class="caption">Presses add up until you press the opposite key.</span>`}
      </div>
      <p role="status">${message}</p>
    </div>
    <div class="key-columns">
      ${block('Driving', lines(DRIVING))}
      ${block('Vehicle', lines(VEHICLE))}
      ${block('Simulation', lines(SCREEN))}
      ${block('Views', [...views.map(({ key, title }) => [key, title]), ...OTHERS].map(fixedLine))}
      ${block(
        'Gamepad',
        GAMEPAD.map(fixedLine),
        html`<p class="caption">For a standard gamepad; change it in the menu.</p>`,
      )}
    </div>
  `;
  const again = openDialog(byId('keys-dialog'), 'Keys', view);
  byId('keys-dialog').addEventListener('close', () => listen(''), { once: true });
}
