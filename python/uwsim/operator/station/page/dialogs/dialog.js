// Dialogs, which release all controls while they are open.
import { draw } from '../dom.js';
import { html } from '../vendor/preact.js';

/** @type {(isOpen: boolean) => void} */
let onChange = () => {};

// Call listener(isOpen) when a dialog opens or the last one closes.
export function watchDialogs(listener) {
  onChange = listener;
}

// contents: a view, or an element. Return a function that draws the dialog again.
export function openDialog(dialog, title, contents) {
  const put = contents instanceof Element ? (body) => body?.append(contents) : null;
  const view = () => html`
    <header class="dialog-head">
      <h2 id=${dialog.getAttribute('aria-labelledby')}>${title}</h2>
      <button type="button" aria-label="Close" onClick=${() => dialog.close()}>✕</button>
    </header>
    <div class="dialog-body" ref=${put}>${put ? null : contents()}</div>
  `;
  const again = draw(dialog, view);
  if (dialog.open) return again;
  dialog.onclose = () => onChange(Boolean(document.querySelector('dialog[open]')));
  dialog.onclick = (event) => {
    if (event.target === dialog) dialog.close();
  }; // outside
  onChange(true);
  dialog.showModal();
  return again;
}
