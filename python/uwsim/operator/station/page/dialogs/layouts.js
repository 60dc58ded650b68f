// The dialog of layouts: those of the tasks and the pilot's own, the panel, and a window for the large view alone.
import { byId, el, toast } from '../dom.js';
import { keep, saved, TASKS } from '../views/arrangement.js';
import { openDialog } from './dialog.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.layouts;
const NAME_MAX = 40;
const WINDOW = 'popup,width=1280,height=760';

export function showLayouts(views) {
  const dialog = byId('layouts-dialog');
  const own = Object.entries(saved());
  const choose = (arrangement) => {
    views.arrange(arrangement);
    dialog.close();
  };
  const button = (text, arrangement) => el('button', { type: 'button', onclick: () => choose(arrangement) }, text);
  openDialog(
    dialog,
    WORDS.title,
    el('div', { className: 'stack' }, ...Object.entries(TASKS).map(([name, each]) => button(WORDS.names[name], each))),
    ...own.map(([name, each]) =>
      el(
        'div',
        { className: 'row' },
        button(name, each),
        forget(name, () => showLayouts(views)),
      ),
    ),
    el('hr'),
    switchOf(WORDS.panel, views.arrangement.panel, (panel) => views.arrange({ ...views.arrangement, panel })),
    switchOf(WORDS.small, views.arrangement.small?.length !== 0, (isShown) =>
      views.arrange({ ...views.arrangement, small: isShown ? null : [] }),
    ),
    saveForm(views, () => showLayouts(views)),
    el('hr'),
    el('div', { className: 'stack' }, popOut(views.largeView)),
  );
}

const switchOf = (text, checked, change) =>
  el(
    'label',
    { className: 'switch' },
    el('input', { type: 'checkbox', checked, onchange: ({ target }) => change(target.checked) }),
    text,
  );

function forget(name, again) {
  const act = () => {
    keep(name, null);
    again();
  };
  return el('button', { type: 'button', 'aria-label': WORDS.delete(name), onclick: act }, '✕');
}

function saveForm(views, again) {
  const name = el('input', { type: 'text', maxLength: NAME_MAX, 'aria-label': WORDS.name, autocomplete: 'off' });
  const save = (event) => {
    event.preventDefault();
    if (!name.value.trim()) return;
    keep(name.value.trim(), { ...views.arrangement, large: views.large });
    toast(WORDS.saved(name.value.trim()));
    again();
  };
  return el('form', { className: 'row', onsubmit: save }, name, el('button', { type: 'submit' }, WORDS.save));
}

// The large view for a second screen, in a page that takes no controls.
function popOut({ title, view }) {
  const url = new URL(location.href);
  url.searchParams.set('view', view.name);
  url.searchParams.set('alone', '');
  return el('button', { type: 'button', onclick: () => open(url, '_blank', WINDOW) }, WORDS.popOut(title));
}
