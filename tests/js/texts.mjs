// The texts of the station's page that are not in its table of strings. node texts.mjs [FOLDER]: prints one per line,
// and exits with 1 if there are any. A text is what a person may read: all literals that reach the document as such, and
// any others that look like words. Attributes and constants of the browser are known by where they stand.
import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';

import { parsers } from '../../build/js/node_modules/prettier/plugins/acorn.mjs';

const HERE = dirname(fileURLToPath(import.meta.url));
const PAGE = process.argv[2] ?? join(HERE, '../../python/uwsim/operator/station/page');
const LETTER = /\p{L}/u;
// Two words, a capitalized one, the end of a sentence, or a word beside a value (\uE000).
const WORDS =
  /\p{L}{2,}[,:;]?[ ’']\p{L}|^\p{Lu}\p{Ll}+[.:]?$|\p{L}{2,}( …|[.!?…])$|\uE000 \p{L}{2,}|\p{L}{2,}:? \uE000|^ \p{L}/u;
const UNITS = /(?<!\p{L})(m|cm|km|s|ms|min|h|dB|Hz|kHz|MB|kPa|m\/s|x)(?!\p{L})/gu;
const CODES =
  /^(Key[A-Z]|Digit\d|Semicolon|Quote|Comma|Period|Equal|Minus|Backquote|Backslash|Backspace|Delete|Space|Escape|Enter|Tab)$/; // of keys
const GENERATED = /wire[\\/]messages\.js$/;
const NONE = /^\n(uniform|precision) |^input, select, textarea, |^big-values small$/; // shaders, a selector, classes

// Functions whose arguments people read: from the first of these positions to before the second.
const READ = {
  el: [2, 99],
  write: [1, 2],
  toast: [0, 1],
  attempt: [1, 2],
  append: [0, 99],
  replaceChildren: [0, 99],
  fillText: [0, 1],
};
// Properties and attributes that people read.
const SHOWN =
  /^(title|label|placeholder|alt|text|hint|textContent|aria-(label|description|roledescription|valuetext))$/;
// Functions whose arguments nobody reads.
const UNREAD =
  /^(all|first|querySelector|querySelectorAll|closest|matches|getElementById|byId|addEventListener|removeEventListener|getContext|toggle|add|remove|contains|getItem|setItem|Event|matchMedia|test|setProperty|getPropertyValue|isTypeSupported|createElement|getExtension|fetch|URL|startsWith|endsWith|includes|shader)$/;
const QUIET =
  /^(className|type|role|id|htmlFor|autocomplete|inputMode|cursor|font|fillStyle|strokeStyle|textAlign|textBaseline|rel|target|download|href|src|value|code|style)$/;

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
    if (parent.type === 'MemberExpression' && parent.object === node) return '';
    if (parent.type === 'TaggedTemplateExpression') return 'unread';
    if (parent.type === 'SwitchCase' || /^(Import|Export)\w*Declaration$/.test(parent.type)) {
      if (parent.source === node || parent.type === 'SwitchCase') return 'unread';
    }
    if (parent.type === 'ConditionalExpression' && parent.test === node) return '';
    if (parent.type === 'Property' || parent.type === 'PropertyDefinition') {
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
      if (index >= 0 && UNREAD.test(name)) return 'unread';
      if (index >= 0 && Object.hasOwn(READ, name)) {
        const [from, to] = READ[name];
        if (index >= from && index < to) return 'shown';
        if (node.type !== 'ObjectExpression') return 'unread';
      }
      if (index >= 0) return '';
    }
    if (/Function/.test(parent.type) && node.type === 'BlockStatement') return '';
  }
  return '';
}

function* literals(node, path = []) {
  if (!node || typeof node.type !== 'string') return;
  const here = [...path, node];
  if (node.type === 'Literal' && typeof node.value === 'string') yield [node.value, here];
  if (node.type === 'TemplateLiteral') yield [node.quasis.map(({ value }) => value.cooked).join('\uE000'), here];
  for (const [key, child] of Object.entries(node)) {
    if (key === 'loc' || key === 'range' || key === 'comments' || key === 'tokens') continue;
    for (const each of Array.isArray(child) ? child : [child])
      if (each && typeof each === 'object') yield* literals(each, here);
  }
}

const isText = (text, how) => {
  if (how === 'unread' || CODES.test(text) || NONE.test(text)) return false;
  const plain = text.replaceAll(UNITS, '');
  return how === 'shown' ? LETTER.test(plain) : WORDS.test(plain);
};

// Return the texts of a module: { text, node, start, end }, with \uE000 for each value in a template.
export function found(source) {
  return [...literals(parsers.acorn.parse(source, { filepath: 'page.mjs' }))]
    .filter(([text, path]) => isText(text, use(path)))
    .map(([text, path]) => {
      const node = path.at(-1);
      return { text, node, start: node.start ?? node.range[0], end: node.end ?? node.range[1] };
    });
}

function* files(folder) {
  for (const entry of readdirSync(folder, { withFileTypes: true })) {
    const path = join(folder, entry.name);
    if (entry.isDirectory() && entry.name !== 'vendor') yield* files(path);
    else if (entry.name.endsWith('.js') && !GENERATED.test(path)) yield path;
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  for (const path of files(PAGE)) {
    const source = readFileSync(path, 'utf8');
    for (const { text, start } of found(source)) {
      const line = source.slice(0, start).split('\n').length;
      console.log(`${relative(PAGE, path)}:${line}: ${text.replaceAll('\uE000', '…')}`);
      process.exitCode = 1;
    }
  }
}
