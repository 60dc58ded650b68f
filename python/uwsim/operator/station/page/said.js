// Names and alarms that the server sends in English, in the page's language.
import { STRINGS } from './strings.js';

const WORDS = STRINGS.said;
const TITLES = /** @type {Record<string, string>} */ (WORDS.titles);
const HOLDS = STRINGS.holds;
/** @type {[RegExp, (...parts: string[]) => string][]} */
const TEXTS = [
  [/^battery low$/, () => WORDS.batteryLow],
  [/^water inside$/, () => WORDS.waterInside],
  [/^thruster (.+) does not obey$/, (name) => WORDS.thruster(name)],
  [/^sensor (.+) is silent$/, (name) => WORDS.silent(name)],
  [/^sensor (.+) is stuck$/, (name) => WORDS.stuck(name)],
  [/^([a-z, ]+) hold ended: (.+)$/, (names, why) => WORDS.holdEnded(names.split(', ').map(hold).join(', '), said(why))],
  [/^the sensor of kind (.+) has no valid reading$/, (kind) => WORDS.noReading(kind)],
];

const hold = (name) => /** @type {Record<string, any>} */ (HOLDS[name] ?? name).toLowerCase();

/** An alarm or a note; a text that is not known stays as it is.
 * @type {(text: string) => string}
 */
export function said(text) {
  for (const [pattern, words] of TEXTS) {
    const found = pattern.exec(text);
    if (found) return words(...found.slice(1));
  }
  return text;
}

/** The title of a camera or sonar, of the scenario's own names only where they are usual ones.
 * @type {(view: { name: string, title: string }) => string}
 */
export const titled = ({ name, title }) => (name.includes('/') ? title : (TITLES[name] ?? title));
