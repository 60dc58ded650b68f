// Dialogs, which release all controls while they are open.
import { el } from '../dom.js';

/** @type {(isOpen: boolean) => void} */
let onChange = () => {};

// Call listener(isOpen) when a dialog opens or the last one closes.
export function watchDialogs(listener) {
  onChange = listener;
}

export function openDialog(dialog, title, ...contents) {
  const head = el(
    'header',
    { className: 'dialog-head' },
    el('h2', { id: dialog.getAttribute('aria-labelledby') }, title),
    el('button', { type: 'button', 'aria-label': 'Close', onclick: () => dialog.close() }, '✕'),
  );
  dialog.replaceChildren(head, el('div', { className: 'dialog-body' }, ...contents.filter(Boolean)));
  if (dialog.open) return;
  dialog.onclose = () => onChange(Boolean(document.querySelector('dialog[open]')));
  dialog.onclick = (event) => {
    if (event.target === dialog) dialog.close();
  }; // outside
  onChange(true);
  dialog.showModal();
}
