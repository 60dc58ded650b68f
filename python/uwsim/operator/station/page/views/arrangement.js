// Arrangements of the screen by task: which view is large, which are small, and whether the panel is shown. The pilot's
// own are kept in the browser.
import { isHandheld, isNarrow } from '../handheld.js';
import { SONAR_KINDS } from '../wire/messages.js';

/** large, small: kinds of views, or names. small: null for all. most: of the small ones, first of its list.
 * @typedef {{ large: string, small: string[] | null, panel: boolean, most?: number }} Arrangement
 */

const STORED = 'uwsim.layouts';
/** @type {Record<string, Arrangement>} */
export const TASKS = {
  transit: { large: 'camera', small: ['chart', 'fan', 'forward_looking'], panel: false },
  inspection: { large: 'camera', small: null, panel: true },
  survey: { large: 'scene', small: ['camera', 'chart', 'fan', ...SONAR_KINDS], panel: true },
};

/** @type {Record<'tablet' | 'phone', Arrangement>} */
const HAND_HELD = {
  tablet: { large: 'camera', small: ['chart', 'fan', 'forward_looking', 'camera'], panel: true, most: 3 },
  phone: { large: 'camera', small: ['chart', 'camera'], panel: true, most: 1 },
};

/** What a screen shows until its pilot chooses. */
export const unchosen = () => (isHandheld() ? HAND_HELD[isNarrow() ? 'phone' : 'tablet'] : TASKS.inspection);

/** @returns {Record<string, Arrangement>} */
export function saved() {
  try {
    return JSON.parse(localStorage.getItem(STORED) ?? '{}');
  } catch {
    return {};
  }
}

/** Keep an arrangement under a name, or forget it.
 * @type {(name: string, arrangement: Arrangement | null) => void}
 */
export function keep(name, arrangement) {
  const { [name]: _, ...others } = saved();
  localStorage.setItem(STORED, JSON.stringify(arrangement ? { ...others, [name]: arrangement } : others));
}

/** Test if a list of kinds or names has a view.
 * @type {(list: string[] | null, view: { kind: string, name: string }) => boolean}
 */
export const has = (list, { kind, name }) => list === null || list.includes(kind) || list.includes(name);

/** The names of the small views of an arrangement, beside the large one.
 * @type {(arrangement: Arrangement, views: { kind: string, name: string }[], large: string) => string[]}
 */
export function smallOnes({ small, most }, views, large) {
  const found = views.filter((view) => view.name !== large && has(small, view));
  if (small === null || most === undefined) return found.map(({ name }) => name);
  const place = ({ kind, name }) => small.findIndex((each) => each === kind || each === name);
  return found
    .toSorted((a, b) => place(a) - place(b))
    .map(({ name }) => name)
    .slice(0, most);
}
