// Arrangements of the screen by task: which view is large, which are small, and whether the panel is shown. The pilot's
// own are kept in the browser.
import { SONAR_KINDS } from '../wire/messages.js';

/** large, small: kinds of views, or names. small: null for all.
 * @typedef {{ large: string, small: string[] | null, panel: boolean }} Arrangement
 */

const STORED = 'uwsim.layouts';
/** @type {Record<string, Arrangement>} */
export const TASKS = {
  transit: { large: 'camera', small: ['chart', 'fan', 'forward_looking'], panel: false },
  inspection: { large: 'camera', small: null, panel: true },
  survey: { large: 'scene', small: ['camera', 'chart', 'fan', ...SONAR_KINDS], panel: true },
};

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
