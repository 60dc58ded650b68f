// The editor's keys.
import { first, targetOf } from '../dom.js';
import { moved, raised, turned } from './geometry.js';

const STEPS_M = { plain: 1, shift: 10, alt: 0.1 };
const RAISE = 0.5; // of a step
const MOVES = /** @type {Record<string, [number, number]>} */ ({
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
});
const TURNS = { q: 5, e: -5, Q: 1, E: -1 }; // degrees
const PICKS = { n: 1, p: -1 };

// The keys of the whole editor: Ctrl S, Z and Y.
export function editorKey(event, acts) {
  const key = event.key.toLowerCase();
  if (!(event.ctrlKey || event.metaKey)) return;
  if (key === 's') acts.save();
  else if (hasOwnText(targetOf(event))) return;
  else if (key === 'y' || (key === 'z' && event.shiftKey)) acts.redo();
  else if (key === 'z') acts.undo();
  else return;
  event.preventDefault();
}

// True for an input with a text that is not yet a value of the scenario, which it undoes itself.
function hasOwnText(element) {
  if (!element.matches('input')) return false;
  const { value, defaultValue } = /** @type {HTMLInputElement} */ (/** @type {unknown} */ (element));
  return value !== defaultValue || element.closest('[data-wrong]') !== null;
}

// The keys of the chart and the 3D view, most of them on the selected part. editor: the SceneEditor.
export function chartKey(event, editor, acts) {
  if (event.ctrlKey || event.metaKey) return;
  const act = actOf(event, editor, acts);
  if (!act) return;
  act();
  event.preventDefault();
  event.stopPropagation();
}

function actOf({ key, shiftKey, altKey }, editor, acts) {
  const { parts, part, view } = editor;
  const count = parts.list.length;
  const views = {
    '+': () => view.zoom(1.2),
    '-': () => view.zoom(1 / 1.2),
    f: acts.fit,
    a: acts.add,
    v: acts.turn,
    ',': acts.earlier,
    '.': acts.later,
    b: () => editor.brush.next(),
    '[': () => editor.brush.widen(false),
    ']': () => editor.brush.widen(true),
  };
  if (views[key]) return views[key];
  if (PICKS[key] && count) {
    const from = editor.selected < 0 && PICKS[key] < 0 ? 0 : editor.selected;
    return () => editor.pick((from + PICKS[key] + count) % count);
  }
  if (!part) return null;
  const [shown, fields] = [parts.at(editor.selected), editor.parts.fieldsOf(part)];
  const step = shiftKey ? STEPS_M.shift : altKey ? STEPS_M.alt : STEPS_M.plain;
  const raise = { PageUp: RAISE, PageDown: -RAISE }[key];
  const values = MOVES[key]
    ? moved(shown, fields, [MOVES[key][0] * step, MOVES[key][1] * step])
    : TURNS[key]
      ? turned(shown, fields, TURNS[key])
      : raise && raised(shown, fields, raise * step);
  if (values) return () => editor.change(values);
  if (key === 'Delete') return acts.remove;
  if (key === 'F2') return () => first(editor.element, '.editor-form [data-field$=name] input')?.focus();
  return key === 'Enter' ? () => first(editor.element, '.editor-form :is(input, select)')?.focus() : null;
}
