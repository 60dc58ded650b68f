// Names and alarms that the server sends in English, in the page's language.
import { LANGUAGE, STRINGS } from './strings.js';

const WORDS = STRINGS.said;
const TITLES = /** @type {Record<string, string>} */ (WORDS.titles);
const SAYINGS = /** @type {Record<string, string>} */ (WORDS.texts);
const EVENTS = /** @type {Record<'names' | 'details' | 'values', Record<string, string>>} */ (STRINGS.events);
const UNSAID = new Set(['fault', 'holds', 'kind', 'lamp', 'mode', 'name', 'object', 'sonar', 'text', 'then', 'what']); // their values say enough
const HOLDS = STRINGS.holds;
const FAILSAFE = /** @type {Record<string, any>} */ (STRINGS.failsafe);
/** @type {[RegExp, (...parts: string[]) => string][]} */
const TEXTS = [
  [/^thruster (.+) does not obey$/, (name) => WORDS.thruster(name)],
  [/^sensor (.+) is silent$/, (name) => WORDS.silent(name)],
  [/^sensor (.+) is stuck$/, (name) => WORDS.stuck(name)],
  [/^([a-z, ]+) hold ended: (.+)$/, (names, why) => WORDS.holdEnded(names.split(', ').map(hold).join(', '), said(why))],
  [/^(.+) hold became (.+) hold: (.+)$/, (name, then, why) => WORDS.holdBecame(hold(name), hold(then), said(why))],
  [/^a limit is broken: (.+)$/, (title) => WORDS.limitBroken(title)],
  [/^the sensor of kind (.+) has no valid reading$/, (kind) => WORDS.noReading(kind)],
];

/** @type {(name: string) => string} */
const hold = (name) => {
  const word = /** @type {Record<string, any>} */ (HOLDS)[name] ?? name;
  return LANGUAGE === 'de' ? word : word.toLowerCase(); // German nouns keep their capital
};

/** An alarm or a note; a text that is not known stays as it is.
 * @type {(text: string) => string}
 */
export function said(text) {
  if (Object.hasOwn(SAYINGS, text)) return SAYINGS[text];
  for (const [pattern, words] of TEXTS) {
    const found = pattern.exec(text);
    if (found) return words(...found.slice(1));
  }
  return text;
}

/** An event of a recorded flight; names that are not known stay as they are.
 * @type {(event: import('./wire/messages.js').FlightEvent) => string}
 */
export function happened({ name, vehicle, details }) {
  const given = inWords(details);
  return [EVENTS.names[name] ?? name.replaceAll('_', ' '), vehicle, given && `– ${given}`].filter(Boolean).join(' ');
}

/** The values of an event or of a command.
 * @type {(details: import('./wire/messages.js').EventDetail[]) => string}
 */
function inWords(details) {
  const found = details.map(({ name, text }) => [
    UNSAID.has(name) ? '' : (EVENTS.details[name] ?? name),
    EVENTS.values[text] ?? text,
  ]);
  return found.map((each) => each.filter(Boolean).join(' ')).join(', ');
}

/** What a failsafe does, and why.
 * @type {(action: string, cause: string) => string}
 */
export const acts = (action, cause) => STRINGS.failsafe.acts(FAILSAFE[action] ?? action, FAILSAFE[cause] ?? cause);

/** The title of a camera, sonar or proximity sensor, of the scenario's own names only where they are usual ones.
 * @type {(view: { name: string, title: string }) => string}
 */
export const titled = ({ name, title }) => (name.includes('/') ? title : (TITLES[name] ?? title));
