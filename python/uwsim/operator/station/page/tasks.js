// The start screen's question what to do: fly, train, survey, build a scene, or replay. It decides which parts are shown.
import { byId, capital, draw } from './dom.js';
import { html } from './vendor/preact.js';

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
  const { dataset } = byId('start');
  dataset.task = 'fly';
  const choose = (task) => {
    dataset.task = task;
    again();
    act(task);
  };
  const button = ([task, hint]) => html`
    <button type="button" data-task=${task} aria-pressed=${dataset.task === task} onClick=${() => choose(task)}>
      <b>${capital(task)}</b><small>${hint}</small>
    </button>
  `;
  const again = draw(byId('tasks'), () => Object.entries(TASKS).map(button));
}
