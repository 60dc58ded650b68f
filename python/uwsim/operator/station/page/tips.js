// Tips in the theme's colours, where the system's own would be white at night: what `tip` of dom.js has given an element
// is shown while the element is pointed at or has the keyboard's focus. A tip takes no clicks, so it covers no control.
import { el, write } from './dom.js';

const DELAY_MS = 500;
const GAP_PX = 6;

const box = el('p', { className: 'tip', popover: 'manual', 'aria-hidden': 'true' });
/** @type {HTMLElement | null} */
let owner = null;
let timer = 0;
const changes = new MutationObserver(() => owner && show());

function hide() {
  clearTimeout(timer);
  changes.disconnect();
  owner = null;
  if (box.isConnected) box.hidePopover();
}

function show() {
  if (!owner?.isConnected || !owner.dataset.tip) return hide();
  write(box, owner.dataset.tip);
  if (!box.isConnected) document.body.append(box);
  box.showPopover();
  const { left, top, bottom } = owner.getBoundingClientRect();
  const { width, height } = box.getBoundingClientRect();
  const isBelow = bottom + GAP_PX + height <= innerHeight;
  box.style.left = `${Math.max(GAP_PX, Math.min(left, innerWidth - width - GAP_PX))}px`;
  box.style.top = `${isBelow ? bottom + GAP_PX : Math.max(0, top - height - GAP_PX)}px`;
}

// A tip goes where its element goes, and ends if the element left the pointer.
function move() {
  if (!owner?.matches(':hover, :focus-visible')) hide();
  else if (box.matches(':popover-open')) show();
}

/** @type {(target: EventTarget | null) => void} */
function follow(target) {
  const next = target instanceof Element ? /** @type {HTMLElement | null} */ (target.closest('[data-tip]')) : null;
  if (next === owner) return;
  hide();
  if (!next) return;
  owner = next;
  changes.observe(next, { attributeFilter: ['data-tip'] });
  timer = setTimeout(show, DELAY_MS);
}

addEventListener('pointerover', ({ target, pointerType }) => follow(pointerType === 'touch' ? null : target));
addEventListener(
  'focusin',
  ({ target }) => target instanceof Element && target.matches(':focus-visible') && follow(target),
);
addEventListener('focusout', hide);
for (const each of ['pointerdown', 'keydown', 'blur']) addEventListener(each, hide);
addEventListener('resize', move);
addEventListener('scroll', move, true);
