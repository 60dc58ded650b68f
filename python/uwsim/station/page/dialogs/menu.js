// The pause menu.
import { attempt, byId, el } from '../dom.js';
import { THEMES, theme, setTheme } from '../theme.js';
import { openDialog } from './dialog.js';

export function showMenu(station, { keys, resume }) {
  const { isPilot, state } = station;
  const dialog = byId('menu-dialog');
  const item = (text, act, { only = true, hint = '', className = '' } = {}) => el('button', {
    type: 'button', disabled: only && !isPilot, className,
    onclick: () => { dialog.close(); act(); },
  }, text, hint ? el('small', { className: 'caption' }, hint) : null);
  const name = el('input', { type: 'text', id: 'save-name', value: `${station.description?.scenario ?? 'session'}`, 'aria-label': 'Name to save under', autocomplete: 'off', spellcheck: false });
  openDialog(dialog, state.paused ? 'Paused' : 'Menu',
    el('div', { className: 'stack' },
      state.paused ? item('Resume', resume) : item('Pause', resume),
      item('Restart from the beginning', () => attempt(station.control('restart'), 'Restarted')),
      item('Keys', keys, { only: false, hint: '?' })),
    el('hr'),
    el('form', {
      className: 'row', onsubmit: (event) => {
        event.preventDefault();
        dialog.close();
        attempt(station.control('save', { name: name.value.trim() })).then((answer) => answer && attempt(Promise.resolve({ success: true }), answer.message || 'Saved'));
      },
    }, el('label', { htmlFor: 'save-name' }, 'Save as'), name, el('button', { type: 'submit', disabled: !isPilot }, 'Save')),
    el('hr'),
    el('div', { className: 'row apart' }, el('span', {}, 'Colours'), el('div', { className: 'row', role: 'group', 'aria-label': 'Colours' },
      ...THEMES.map((kind) => el('button', {
        type: 'button', 'aria-pressed': String(theme() === kind), onclick: (event) => {
          setTheme(kind);
          for (const other of event.target.parentElement.children) other.setAttribute('aria-pressed', String(other === event.target));
        },
      }, kind)))),
    el('hr'),
    el('div', { className: 'stack' }, item('Quit to the start screen', () => attempt(station.control('quit')), { className: 'danger' })),
    isPilot ? null : el('p', { className: 'caption' }, 'Only the pilot can change the run.'));
}
