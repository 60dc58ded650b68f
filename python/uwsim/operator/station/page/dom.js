// Small helpers for the document.
import { html, render, signal } from './vendor/preact.js';

/** An element that the document or a module of the page has made, so that it exists; what it is depends on its name.
 * @typedef {HTMLElement & Pick<HTMLInputElement, 'value' | 'disabled' | 'checked' | 'min' | 'max'>
 *   & Pick<HTMLDialogElement, 'open' | 'close' | 'showModal'> & Pick<HTMLFormElement, 'elements'>} Known
 */

/** @type {(id: string) => Known} */
export const byId = (id) => /** @type {Known} */ (document.getElementById(id));

/** The first element below `root` that a selector matches.
 * @type {(root: ParentNode, selector: string) => Known}
 */
export const first = (root, selector) => /** @type {Known} */ (root.querySelector(selector));

/** All elements below `root` that a selector matches.
 * @type {(root: ParentNode, selector: string) => NodeListOf<Known>}
 */
export const all = (root, selector) => root.querySelectorAll(selector);

/** The element that an event happened to.
 * @type {(event: Event) => Known}
 */
export const targetOf = (event) => /** @type {Known} */ (event.target);

/** Make an element: el('button', { type: 'button', onclick, 'aria-label': '...', title: '...' }, 'text', child).
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, any>} attributes
 * @param {(Node | string | null | undefined)[]} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name in element && name !== 'list' && !name.includes('-')) element[name] = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** Targets with those of their events that are followed. @typedef {[EventTarget, ...string[]][]} Followed */

/** A signal of what a function returns, which is called again at events.
 * @type {<T>(read: () => T, ...followed: Followed) => { value: T }}
 */
export function watched(read, ...followed) {
  const found = signal(read());
  const again = () => void (found.value = read());
  for (const [target, ...events] of followed) for (const event of events) target.addEventListener(event, again);
  return found;
}

/** A component of a view. It is drawn again at events, and when a signal that it reads or one of its properties changes,
 * not with what is around it.
 * @type {(view: (props?: any) => any, ...followed: Followed) => any}
 */
export function part(view, ...followed) {
  let times = 0;
  const drawn = watched(() => (times += 1), ...followed);
  return Object.assign((props) => (drawn.value, view(props)), { again: () => void (drawn.value = times += 1) });
}

/** Draw a view in an element, as a part. Return a function that draws it again.
 * @type {(root: Element, view: () => any, ...followed: Followed) => () => void}
 */
export function draw(root, view, ...followed) {
  const drawn = part(view, ...followed);
  render(html`<${drawn} />`, root);
  return drawn.again;
}

/** The canvas's context for drawing.
 * @template {HTMLCanvasElement | OffscreenCanvas} T
 * @param {T} canvas
 */
export const pen = (canvas) =>
  /** @type {T extends HTMLCanvasElement ? CanvasRenderingContext2D : OffscreenCanvasRenderingContext2D} */ (
    canvas.getContext('2d')
  );

// Write text only if it differs, to avoid a needless layout ten times a second.
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

let toastTimer = 0;
export function toast(text, kind = 'info') {
  const box = byId('toast');
  box.textContent = text;
  box.dataset.kind = kind;
  box.classList.add('is-shown');
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => box.classList.remove('is-shown'), kind === 'error' ? 6000 : 3000);
}

// Await the server's answer, and show a refusal. If `done` is given, show success, too: the answer's message, or else
// `done`. Return the answer, or null after a refusal.
export async function attempt(promise, done = '') {
  try {
    const answer = await promise;
    if (answer?.success === false) {
      toast(answer.message || 'The simulator refused.', 'error');
      return null;
    }
    if (done) toast(answer?.message || done);
    return answer ?? {};
  } catch (error) {
    toast(error.message, 'error');
    return null;
  }
}

// Capitalise a text such as 'a rosbridge client' for the beginning of a sentence.
export const capital = (text) => text.replace(/^./, (letter) => letter.toUpperCase());

// A whole number with its thousands grouped.
export const grouped = (value) => value.toLocaleString('en');

export const fixed = (value, digits) =>
  Number.isFinite(value) ? value.toFixed(digits).replace(/^-(0(\.0*)?)$/, '$1') : '–';

export function clockText(seconds, digits = 0) {
  if (!Number.isFinite(seconds)) return '–';
  const shown = Number(seconds.toFixed(digits)); // so that 119.6 is not 1:60
  const [hours, minutes] = [Math.floor(shown / 3600), Math.floor(shown / 60) % 60];
  const rest = (shown % 60).toFixed(digits).padStart(digits ? 3 + digits : 2, '0');
  return hours ? `${hours}:${String(minutes).padStart(2, '0')}:${rest}` : `${minutes}:${rest}`;
}
