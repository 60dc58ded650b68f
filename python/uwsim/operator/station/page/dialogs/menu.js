// The pause menu, which pauses the simulation while it is open.
import { attempt, byId, capital, el, first, toast } from '../dom.js';
import { setTheme, theme, THEMES } from '../theme.js';
import { setUnit, unit, UNITS } from '../units.js';
import { keepName } from '../wire/name.js';
import { openDialog } from './dialog.js';

export function showMenu(station, { keys, gamepad, edit }) {
  const dialog = byId('menu-dialog');
  const { isPilot } = station;
  const mayPause = isPilot && station.may('pause');
  let resumes = mayPause && !station.state.paused; // whether to resume when the menu closes
  if (resumes) attempt(station.control('pause'));
  const leave = (act, staysPaused = false) => {
    if (staysPaused) resumes = false;
    dialog.close();
    act?.();
  };
  // Entries that an exercise does not permit are left out.
  const item = (text, act, { forAll = false, hint = '', className = '', control = '' } = {}) =>
    control && !station.may(control)
      ? null
      : el(
          'button',
          { type: 'button', disabled: !forAll && !isPilot, className, onclick: act },
          text,
          hint ? el('small', { className: 'caption' }, hint) : null,
        );

  const quit = item('Quit to the start screen', () => leave(() => attempt(station.control('quit')), true), {
    className: 'danger',
  });

  openDialog(
    dialog,
    mayPause ? 'Paused' : 'Menu',
    isPilot ? null : el('p', { className: 'caption' }, 'Only the pilot can control the simulation.'),
    el(
      'div',
      { className: 'stack' },
      item(
        'Resume',
        () => {
          resumes = mayPause;
          leave();
        },
        { control: 'pause' },
      ),
      item('Close, and stay paused', () => leave(null, true), { control: 'pause' }),
      item('Restart from the beginning', () => leave(() => attempt(station.control('restart'), 'Restarted')), {
        control: 'restart',
      }),
      item('Keys', () => leave(keys), { forAll: true, hint: '?' }),
      ...(station.description?.is_fixed || station.description?.replay
        ? []
        : [item('Edit the scene', () => leave(edit, true), { control: 'pause' })]),
      item('Gamepad', () => leave(gamepad), { forAll: true }),
    ),
    el('hr'),
    nameForm(station),
    station.may('save') ? saveForm(station, isPilot, leave) : null,
    el('hr'),
    choice('Colours', THEMES, theme, setTheme),
    choice('Lengths', UNITS, unit, setUnit),
    ...(station.description?.is_fixed || !station.may('quit')
      ? []
      : [el('hr'), el('div', { className: 'stack' }, quit)]),
  );
  first(dialog, '.stack button:not(:disabled)')?.focus();
  dialog.addEventListener(
    'close',
    () => {
      if (resumes) attempt(station.control('resume'));
    },
    { once: true },
  );
}

function nameForm(station) {
  const name = el('input', {
    type: 'text',
    id: 'pilot-name',
    value: station.name,
    maxLength: 40,
    autocomplete: 'off',
    spellcheck: false,
  });
  const rename = async (event) => {
    event.preventDefault();
    if (await attempt(station.rename(name.value.trim()), 'Your name has been changed')) keepName(station.name);
  };
  return el(
    'form',
    { className: 'row', onsubmit: rename },
    el('label', { htmlFor: 'pilot-name' }, 'Your name'),
    name,
    el('button', { type: 'submit' }, 'Change'),
  );
}

function saveForm(station, maySave, leave) {
  const name = el('input', {
    type: 'text',
    id: 'save-name',
    value: station.description?.scenario ?? 'session',
    autocomplete: 'off',
    spellcheck: false,
  });
  const save = async (event) => {
    event.preventDefault();
    leave();
    const answer = await attempt(station.control('save', { name: name.value.trim() }));
    if (answer) toast(answer.message || 'Saved');
  };
  return el(
    'form',
    { className: 'row', onsubmit: save },
    el('label', { htmlFor: 'save-name' }, 'Save as'),
    name,
    el('button', { type: 'submit', disabled: !maySave }, 'Save'),
  );
}

// A row of buttons, one for each value of a setting.
function choice(title, values, current, choose) {
  const press = (event) => {
    choose(event.target.value);
    for (const other of event.target.parentElement.children)
      other.setAttribute('aria-pressed', String(other === event.target));
  };
  return el(
    'div',
    { className: 'row apart' },
    el('span', {}, title),
    el(
      'div',
      { className: 'row', role: 'group', 'aria-label': title },
      ...values.map((value) =>
        el(
          'button',
          { type: 'button', value, 'aria-pressed': String(current() === value), onclick: press },
          capital(value),
        ),
      ),
    ),
  );
}
