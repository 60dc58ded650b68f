// Which number key enlarges which view. Each kind has keys of its own, so that a key shows the same in every scenario.
import { SONAR_KINDS } from '../wire/messages.js';

/** @type {Record<string, number[]>} */
const KEYS = { camera: [1, 2], chase: [3], scene: [4], chart: [5], fan: [6], sonar: [7, 8], station: [9, 0] };
const ALL = Object.values(KEYS).flat();

/** The key of each view by its name; views beyond the keys of their kind take those that are left, in their order.
 * @type {(views: { name: string, kind: string }[]) => Map<string, number>}
 */
export function numberKeys(views) {
  const found = new Map();
  const free = new Set(ALL);
  const take = (name, keys) => {
    const key = keys.find((each) => free.has(each));
    if (key === undefined) return;
    found.set(name, key);
    free.delete(key);
  };
  for (const { name, kind } of views) take(name, KEYS[SONAR_KINDS.includes(kind) ? 'sonar' : kind] ?? []);
  for (const { name } of views) if (!found.has(name)) take(name, ALL);
  return found;
}
