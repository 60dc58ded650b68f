// The texts of the page, by topic, from strings/*.json. To add a language, add a file with the keys of en.json, and its
// two lines here. Texts from the server (errors, alarms, names and descriptions) are always English.
//
// The key `name(a, b)` is a function of values: in its text, {a} is a value; [a?x|y] is x if `a` is true, else y;
// [a=1?x|y] is x if `a` is 1, else y.
import german from './strings/de.json' with { type: 'json' };
import english from './strings/en.json' with { type: 'json' };

const CHOICE = /\[(\w+)(?:=(\w+))?\?([^|]*)\|([^\]]*)\]/g;
const STORED = 'uwsim.language';

/** @template T
 * @typedef {{
 *   [K in keyof T as K extends `${infer Name}(${string}` ? Name : K]:
 *     T[K] extends string ? (K extends `${string}(${string}` ? (...values: any[]) => string : string) : T[K]
 * }} Topic
 */
/** @typedef {{ [K in keyof typeof english]: Topic<(typeof english)[K]> }} Table */

function filled(text, names, given) {
  const values = Object.fromEntries(names.map((name, k) => [name, given[k]]));
  const is = (name, value) => (value === undefined ? values[name] : String(values[name]) === value);
  return text
    .replace(CHOICE, (_, name, value, yes, no) => (is(name, value) ? yes : no))
    .replace(/\{(\w+)\}/g, (_, name) => values[name]);
}

function entry(key, text) {
  if (typeof text !== 'string') return [key, text];
  const [, name, names] = key.match(/^(\w+)\((.*)\)$/) ?? [];
  return name ? [name, (...given) => filled(text, names.split(', '), given)] : [key, text];
}

/** @type {(file: object) => Table} */
const table = (file) =>
  /** @type {any} */ (
    Object.fromEntries(
      Object.entries(file).map(([topic, words]) => [
        topic,
        Object.fromEntries(Object.entries(words).map(([key, text]) => entry(key, text))),
      ]),
    )
  );

export const FILES = { en: english, de: german };
export const LANGUAGES = ['system', ...Object.keys(FILES)];

// The language chosen in the menu; 'system' means the browser's.
export function chosenLanguage() {
  const kept = globalThis.localStorage?.getItem(STORED);
  return kept && LANGUAGES.includes(kept) ? kept : 'system';
}

// Store the chosen language and reload the page.
export function setLanguage(name) {
  localStorage.setItem(STORED, name);
  location.reload();
}

// The language of the page: the chosen one, else the first of the browser's languages that has a table, else English.
export const LANGUAGE =
  chosenLanguage() !== 'system'
    ? chosenLanguage()
    : ((globalThis.document ? navigator.languages : [])
        .map((each) => each.slice(0, 2).toLowerCase())
        .find((each) => each in FILES) ?? 'en');

export const STRINGS = table(FILES[LANGUAGE]);
