// The start screen's question what to do: fly, train, survey, build a scene, or replay. It decides which parts are shown.
import { byId, el } from './dom.js';
import { STRINGS } from './strings.js';

const WORDS = STRINGS.tasks;
const TASKS = /** @type {const} */ (['fly', 'train', 'survey', 'build', 'replay']);

// act(task): called when a task is chosen.
export function offerTasks(act) {
  const buttons = TASKS.map((task) =>
    el(
      'button',
      { type: 'button', 'data-task': task, onclick: () => choose(task) },
      el('b', {}, WORDS[task]),
      el('small', {}, WORDS.hints[task]),
    ),
  );
  function choose(chosen) {
    byId('start').dataset.task = chosen;
    for (const each of buttons) each.setAttribute('aria-pressed', String(each.dataset.task === chosen));
    act(chosen);
  }
  byId('tasks').setAttribute('aria-label', WORDS.question);
  byId('tasks').append(...buttons);
  choose('fly');
}
