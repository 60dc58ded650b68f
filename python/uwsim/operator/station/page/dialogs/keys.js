// The list of keys, which ? opens; a click on an action and a key press change its key.
import { byId, el } from '../dom.js';
import { ACTIONS, DRIVING, keyName, PRESETS, SCREEN, VEHICLE } from '../drive/bindings.js';
import { openDialog } from './dialog.js';

const fixedLine = (key, text) => el('div', { className: 'key-line' }, el('span', {}, text), el('kbd', {}, key));

// views: see Views.keyed.
export function showKeys(bindings, views) {
  const message = el('p', { role: 'status' }, 'Click an action, then press its new key.');
  let ending = null;

  const line = (action) => {
    const keys = bindings.keysOf(action);
    const button = el(
      'button',
      {
        type: 'button',
        'aria-pressed': 'false',
        'aria-label': `${ACTIONS[action]}: ${keys.map(keyName).join(' ') || 'none'}; change`,
      },
      ...(keys.length
        ? keys.flatMap((code, k) => [k ? ' ' : null, el('kbd', {}, keyName(code))])
        : [el('span', {}, 'none')]),
    );
    button.addEventListener('click', () => listen(action, button));
    return el('div', { className: 'key-line' }, el('span', {}, ACTIONS[action]), button);
  };
  const listen = (action, button) => {
    ending?.();
    button.setAttribute('aria-pressed', 'true');
    button.replaceChildren('Press a key');
    const take = (event) => {
      event.preventDefault();
      event.stopPropagation();
      ending();
      const refusal = event.code === 'Escape' ? '' : bindings.assign(action, event.code);
      render();
      message.textContent = refusal || 'Click an action, then press its new key.';
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
      'Keys',
      el(
        'div',
        { className: 'row apart' },
        el(
          'div',
          { className: 'row', role: 'group', 'aria-label': 'Preset' },
          ...Object.keys(PRESETS).map(choose),
          bindings.isChanged ? el('span', { className: 'caption' }, 'changed') : null,
          bindings.addsUp
            ? el('span', { className: 'caption' }, 'Presses add up until you press the opposite key.')
            : null,
        ),
        message,
      ),
      el(
        'div',
        { className: 'key-columns' },
        block('Driving', DRIVING),
        block('Vehicle', VEHICLE),
        block('Simulation', SCREEN),
        el(
          'section',
          {},
          el('h3', {}, 'Views'),
          ...views.map(({ key, title }) => fixedLine(key, title)),
          fixedLine('?', 'These keys'),
          fixedLine('Enter', 'Begin the exercise'),
          fixedLine('Esc', 'Menu'),
        ),
        el(
          'section',
          {},
          el('h3', {}, 'Gamepad'),
          fixedLine('left stick', 'Up, down, turn'),
          fixedLine('right stick', 'Ahead, sideways'),
          fixedLine('A', 'All stop'),
          fixedLine('LB RB', 'Gain'),
          fixedLine('↑ ↓', 'Sonar tilt'),
          fixedLine('X Y', 'Front light, down light'),
          fixedLine('← →', 'Part of the arm'),
          fixedLine('LT RT', 'Open, close the jaws'),
          fixedLine('Start', 'Release or dock'),
          fixedLine('stick presses', 'Hold heading, depth'),
          el('p', { className: 'caption' }, 'For a standard gamepad; change it in the menu.'),
        ),
      ),
    );
  }
  render();
  byId('keys-dialog').addEventListener('close', () => ending?.(), { once: true });
}
