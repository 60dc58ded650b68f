// The texts of the station's page that are not in its table of strings. node texts.mjs [FOLDER]: prints one per line,
// and exits with 1 if there are any. A text is what a person may read: all literals that reach the document as such, and
// any others that look like words. Attributes and constants of the browser are known by where they stand.
import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';

import { parsers } from '../../build/js/node_modules/prettier/plugins/acorn.mjs';

const HERE = dirname(fileURLToPath(import.meta.url));
const PAGE = process.argv[2] ?? join(HERE, '../../python/uwsim/operator/station/page');
const TABLES = /^strings(_\w+)?\.js$/;
const LETTER = /\p{L}/u;
const WORDS = /\p{L}{2,}[ ’']\p{L}|^\p{Lu}\p{Ll}+[.:]?$|\p{L}{2,}[.:!?…]$|^ \p{L}/u; // two words, a capitalized one, or a sentence's end

// Functions whose arguments, from the given one on, are read by people.
const READ = { el: 2, write: 1, toast: 0, attempt: 1, append: 0, replaceChildren: 0, fillText: 0, Text: 0, openDialog: 1 };
// Properties and attributes that are read by people.
const SHOWN = /^(title|label|placeholder|alt|text|hint|textContent|aria-(label|description|roledescription|valuetext))$/;
// Functions whose arguments never are.
const UNREAD =
  /^(querySelector|querySelectorAll|closest|matches|getElementById|byId|addEventListener|removeEventListener|getContext|toggle|add|remove|contains|getItem|setItem|Event|CustomEvent|matchMedia|test|setProperty|getPropertyValue|isTypeSupported|createElement|getExtension|fetch|import|URL|startsWith|endsWith|includes|replace|replaceAll|split|join|padStart|Error|TypeError|getAttribute|removeAttribute|toggleAttribute|hasAttribute)$/;
const QUIET = /^(className|type|role|id|name|htmlFor|for|autocomplete|inputMode|tag|kind|cursor|font|fillStyle|strokeStyle|textAlign|textBaseline|rel|target|download|href|src|value|dataset|mimeType|code|key|color|colour|style|d|keys)$/;

const nameOf = (node) => node?.name ?? (typeof node?.value === 'string' ? node.value : nameOf2(node));
function nameOf2(node) {
  if (node?.type === 'MemberExpression') return nameOf(node.property);
  return node?.type === 'PrivateIdentifier' ? node.name : '';
}

// How the nearest ancestor that decides treats a literal: 'shown', 'unread', or '' for neither.
function use(path) {
  for (let k = path.length - 1; k > 0; k -= 1) {
    const [parent, node] = [path[k - 1], path[k]];
    if (parent.type === 'BinaryExpression' && /^[!=]==$/.test(parent.operator)) return 'unread';
    if (parent.type === 'MemberExpression' && parent.computed && parent.property === node) return 'unread';
    if (parent.type === 'SwitchCase' || /^(Import|Export)\w*Declaration$/.test(parent.type)) {
      if (parent.source === node || parent.type === 'SwitchCase') return 'unread';
    }
    if (parent.type === 'ConditionalExpression' && parent.test === node) return '';
    if (parent.type === 'Property') {
      if (parent.key === node && !parent.computed) return 'unread';
      const name = nameOf(parent.key);
      if (SHOWN.test(name)) return 'shown';
      if (QUIET.test(name) || name.startsWith('data-') || name.startsWith('aria-')) return 'unread';
    }
    if (parent.type === 'AssignmentExpression' && parent.right === node) {
      const name = nameOf(parent.left);
      if (SHOWN.test(name)) return 'shown';
      if (QUIET.test(name)) return 'unread';
    }
    if (parent.type === 'CallExpression' || parent.type === 'NewExpression') {
      const index = parent.arguments.indexOf(node);
      const name = nameOf(parent.callee);
      if (index >= 0 && name === 'Error') return 'shown'; // its message is shown
      if (index >= 0 && name === 'setAttribute') {
        if (index === 0) return 'unread';
        return SHOWN.test(nameOf(parent.arguments[0])) ? 'shown' : 'unread';
      }
      if (index >= 0 && UNREAD.test(name)) return name === 'replaceAll' || name === 'replace' || name === 'join' ? '' : 'unread';
      if (index >= 0 && name in READ) return index >= READ[name] ? 'shown' : index === 1 ? '' : 'unread';
    }
    if (/Function/.test(parent.type) && node.type === 'BlockStatement') return '';
  }
  return '';
}

function* literals(node, path = []) {
  if (!node || typeof node.type !== 'string') return;
  const here = [...path, node];
  if (node.type === 'Literal' && typeof node.value === 'string') yield [node.value, here];
  if (node.type === 'TemplateLiteral') yield [node.quasis.map(({ value }) => value.cooked).join('\u0001'), here];
  for (const [key, child] of Object.entries(node)) {
    if (key === 'loc' || key === 'range' || key === 'comments' || key === 'tokens') continue;
    for (const each of Array.isArray(child) ? child : [child])
      if (each && typeof each === 'object') yield* literals(each, here);
  }
}

const isText = (text, how) => {
  const plain = text.replaceAll('\u0001', ' ');
  if (how === 'shown') return LETTER.test(plain);
  return how === '' && WORDS.test(plain);
};

const lineOf = (source, node) => source.slice(0, node.start ?? node.range[0]).split('\n').length;

export function textsOf(source) {
  const found = [];
  for (const [text, path] of literals(parsers.acorn.parse(source, { filepath: 'page.mjs' })))
    if (isText(text, use(path))) found.push([lineOf(source, path.at(-1)), text.replaceAll('\u0001', '${}')]);
  return found;
}

function* files(folder) {
  for (const entry of readdirSync(folder, { withFileTypes: true })) {
    const path = join(folder, entry.name);
    if (entry.isDirectory() && entry.name !== 'vendor') yield* files(path);
    else if (entry.name.endsWith('.js') && !TABLES.test(entry.name)) yield path;
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  let count = 0;
  for (const path of files(PAGE))
    for (const [line, text] of textsOf(readFileSync(path, 'utf8'))) {
      console.log(`${relative(PAGE, path)}:${line}: ${text}`);
      count += 1;
    }
  process.exitCode = count ? 1 : 0;
}
