// The list of keys, which ? opens; a click on an action and a key press change its key.
import { byId, el } from '../dom.js';
import { ACTIONS, DRIVING, keyName, PRESETS, SCREEN, VEHICLE } from '../drive/bindings.js';
import { openDialog } from './dialog.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.keysDialog;

const fixedLine = (key, text) => el('div', { className: 'key-line' }, el('span', {}, text), el('kbd', {}, key));

// views: see Views.keyed.
export function showKeys(bindings, views) {
  const message = el('p', { role: 'status' }, WORDS.how);
  let ending = null;

  const line = (action) => {
    const keys = bindings.keysOf(action);
    const button = el(
      'button',
      {
        type: 'button',
        'aria-pressed': 'false',
        'aria-label': WORDS.change(ACTIONS[action], keys.map(keyName).join(' ') || WORDS.none),
      },
      ...(keys.length
        ? keys.flatMap((code, k) => [k ? ' ' : null, el('kbd', {}, keyName(code))])
        : [el('span', {}, WORDS.none)]),
    );
    button.addEventListener('click', () => listen(action, button));
    return el('div', { className: 'key-line' }, el('span', {}, ACTIONS[action]), button);
  };
  const listen = (action, button) => {
    ending?.();
    button.setAttribute('aria-pressed', 'true');
    button.replaceChildren(WORDS.press);
    const take = (event) => {
      event.preventDefault();
      event.stopPropagation();
      ending();
      const refusal = event.code === 'Escape' ? '' : bindings.assign(action, event.code);
      render();
      message.textContent = refusal || WORDS.how;
    };
    ending = () => removeEventListener('keydown', take, true);
    addEventListener('keydown', take, true);
  };
  const block = (title, actions) => el('section', {}, el('h3', {}, title), ...Object.keys(actions).map(line));
  const choose = (preset) =>
    el(
      'button',
      {
        type: 'button',
        'aria-pressed': String(bindings.preset === preset && !bindings.isChanged),
        onclick: () => {
          bindings.choose(preset);
          render();
        },
      },
      PRESETS[preset].name,
    );

  function render() {
    openDialog(
      byId('keys-dialog'),
      WORDS.keys,
      el(
        'div',
        { className: 'row apart' },
        el(
          'div',
          { className: 'row', role: 'group', 'aria-label': WORDS.preset },
          ...Object.keys(PRESETS).map(choose),
          bindings.isChanged ? el('span', { className: 'caption' }, WORDS.changed) : null,
          bindings.addsUp ? el('span', { className: 'caption' }, WORDS.addUp) : null,
        ),
        message,
      ),
      el(
        'div',
        { className: 'key-columns' },
        block(WORDS.driving, DRIVING),
        block(WORDS.vehicle, VEHICLE),
        block(WORDS.simulation, SCREEN),
        el(
          'section',
          {},
          el('h3', {}, WORDS.views),
          ...views.map(({ key, title }) => fixedLine(key, title)),
          fixedLine('?', WORDS.theseKeys),
          fixedLine('Enter', WORDS.begin),
          fixedLine(WORDS.esc, WORDS.menu),
        ),
        el(
          'section',
          {},
          el('h3', {}, WORDS.gamepad),
          fixedLine(WORDS.leftStick, WORDS.upDownTurn),
          fixedLine(WORDS.rightStick, WORDS.aheadSideways),
          fixedLine('A', WORDS.allStop),
          fixedLine(WORDS.lbRb, WORDS.gain),
          fixedLine('↑ ↓', WORDS.sonarTilt),
          fixedLine('X Y', WORDS.lights),
          fixedLine('← →', WORDS.partOfArm),
          fixedLine(WORDS.ltRt, WORDS.jaws),
          fixedLine(WORDS.start, WORDS.releaseOrDock),
          fixedLine(WORDS.stickPresses, WORDS.holdHeadingDepth),
          el('p', { className: 'caption' }, WORDS.ofStandard),
        ),
      ),
    );
  }
  render();
  byId('keys-dialog').addEventListener('close', () => ending?.(), { once: true });
}
