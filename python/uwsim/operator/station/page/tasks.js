// The start screen's question what to do: fly, train, survey, build a scene, or replay. It decides which parts are shown.
import { byId, capital, el } from './dom.js';

// The tasks, and a hint for each.
const TASKS = {
  fly: 'A vehicle in a scene',
  train: 'Exercises with a score',
  survey: 'Lanes over a bed',
  build: 'A scene of your own',
  replay: 'Flights of before',
};

// act(task): called when a task is chosen.
export function offerTasks(act) {
  const buttons = Object.entries(TASKS).map(([task, hint]) =>
    el(
      'button',
      { type: 'button', 'data-task': task, onclick: () => choose(task) },
      el('b', {}, capital(task)),
      el('small', {}, hint),
    ),
  );
  function choose(chosen) {
    byId('start').dataset.task = chosen;
    for (const each of buttons) each.setAttribute('aria-pressed', String(each.dataset.task === chosen));
    act(chosen);
  }
  byId('tasks').setAttribute('aria-label', 'What do you want to do?');
  byId('tasks').append(...buttons);
  choose('fly');
}
