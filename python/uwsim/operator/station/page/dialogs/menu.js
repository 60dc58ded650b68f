// The pause menu, which pauses the simulation while it is open.
import { attempt, byId, capital, first, toast } from '../dom.js';
import { setTheme, theme, THEMES } from '../theme.js';
import { setUnit, unit, UNITS } from '../units.js';
import { html } from '../vendor/preact.js';
import { keepName } from '../wire/name.js';
import { openDialog } from './dialog.js';

export function showMenu(station, { keys, gamepad, edit }) {
  const dialog = byId('menu-dialog');
  const { isPilot, description } = station;
  const mayPause = isPilot && station.may('pause');
  let resumes = mayPause && !station.state.paused; // whether to resume when the menu closes
  if (resumes) attempt(station.control('pause'));
  const leave = (act, staysPaused = false) => {
    if (staysPaused) resumes = false;
    dialog.close();
    act?.();
  };
  const resume = () => {
    resumes = mayPause;
    leave();
  };
  const quit = () => leave(() => attempt(station.control('quit')), true);
  const restart = () => leave(() => attempt(station.control('restart'), 'Restarted'));
  // Entries that an exercise does not permit are left out.
  const item = (text, act, control, { hint = '', className = '' } = {}) =>
    (!control || station.may(control)) &&
    html`
      <button type="button" class=${className} disabled=${Boolean(control) && !isPilot} onClick=${act}>
        ${text}${hint && html`<small class="caption">${hint}</small>`}
      </button>
    `;
  const rename = async (name) => {
    if (await attempt(station.rename(name), 'Your name has been changed')) keepName(station.name);
  };
  const save = async (name) => {
    leave();
    const answer = await attempt(station.control('save', { name }));
    if (answer) toast(answer.message || 'Saved');
  };

  const session = description?.scenario ?? 'session';
  const view = () => html`
    ${!isPilot && html`<p class="caption">Only the pilot can control the simulation.</p>`}
    <div class="stack">
      ${item('Resume', resume, 'pause')}
      ${item('Close, and stay paused', () => leave(null, true), 'pause')}
      ${item('Restart from the beginning', restart, 'restart')}
      ${item('Keys', () => leave(keys), '', { hint: '?' })}
      ${!description?.is_fixed && !description?.replay && item('Edit the scene', () => leave(edit, true), 'pause')}
      ${item('Gamepad', () => leave(gamepad), '')}
    </div>
    <hr />
    ${nameForm('pilot-name', 'Your name', station.name, 'Change', rename)}
    ${station.may('save') && nameForm('save-name', 'Save as', session, 'Save', save, !isPilot)}
    <hr />
    ${choice('Colours', THEMES, theme, setTheme, () => again())}
    ${choice('Lengths', UNITS, unit, setUnit, () => again())}
    ${
      !description?.is_fixed &&
      station.may('quit') &&
      html`<hr /><div class="stack">${item('Quit to the start screen', quit, 'quit', { className: 'danger' })}</div>`
    }
  `;
  const again = openDialog(dialog, mayPause ? 'Paused' : 'Menu', view);
  first(dialog, '.stack button:not(:disabled)')?.focus();
  dialog.addEventListener('close', () => resumes && attempt(station.control('resume')), { once: true });
}

// A form with one name.
function nameForm(id, label, value, text, act, mayNot = false) {
  const submit = (event) => {
    event.preventDefault();
    act(byId(id).value.trim());
  };
  return html`
    <form class="row" onSubmit=${submit}>
      <label for=${id}>${label}</label>
      <input type="text" id=${id} defaultValue=${value} maxlength=${id === 'pilot-name' ? 40 : null} autocomplete="off"
        spellcheck="false" />
      <button type="submit" disabled=${mayNot}>${text}</button>
    </form>
  `;
}

// A row of buttons, one for each value of a setting.
function choice(title, values, current, choose, again) {
  const button = (value) => {
    const press = () => {
      choose(value);
      again();
    };
    return html`
      <button type="button" value=${value} aria-pressed=${current() === value} onClick=${press}>
        ${capital(value)}
      </button>
    `;
  };
  return html`
    <div class="row apart">
      <span>${title}</span>
      <div class="row" role="group" aria-label=${title}>${values.map(button)}</div>
    </div>
  `;
}
