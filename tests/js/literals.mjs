// The search for texts finds those of every kind that the page uses, and takes nothing else for one.
import assert from 'node:assert/strict';

import { found } from './texts.mjs';

const texts = (source) => found(source).map(({ text }) => text);
const isFound = (source, text) => assert.deepEqual(texts(source), [text], source);
const isQuiet = (source) => assert.deepEqual(texts(source), [], source);

isFound("el('p', {}, 'none');", 'none');
isFound("el('button', { 'aria-label': 'close' }, '✕');", 'close');
isFound("el('input', { placeholder: isOn ? 'on' : '' });", 'on');
isFound("write(box, isOld ? `${age} s old` : '–');", '\uE000 s old');
isFound("toast('saved', 'error');", 'saved');
isFound("attempt(call('save'), 'done');", 'done');
isFound("throw new Error('no answer');", 'no answer');
isFound("box.setAttribute('title', 'open');", 'open');
isFound("class A { title = '3D map'; }", '3D map');
isFound("const NAMES = { up: 'Turn up' };", 'Turn up');
isFound("button('Assign', act);", 'Assign');
isFound("show('starting …');", 'starting …');
isFound('class A { #private() { return `in ${this.#a} steps`; } }', 'in \uE000 steps');
isFound("context.fillText('far', 1, 2);", 'far');

isQuiet("import { a } from './two words.js';");
isQuiet("el('div', { className: 'row apart', role: 'group', id: 'x' }, `${value} m/s`);");
isQuiet("byId('menu'); document.querySelector('dialog[open] button');");
isQuiet("if (event.code === 'Space' || state === 'running') call('/station/plan', { action: 'fly' });");
isQuiet("box.dataset.kind = isOn ? 'warn' : '';");
isQuiet("const KEYS = { stop: ['KeyX', 'Period'] };");
isQuiet("canvas.getContext('2d'); matchMedia('(min-width: 3px)'); addEventListener('pointer up', act);");
