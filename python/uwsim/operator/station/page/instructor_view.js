// The trainee's view on the instructor's page: a camera's picture, the chart with the track, the link.
import { el } from './dom.js';
import { Link } from './panel/link.js';
import { titled } from './said.js';
import { ChartView } from './views/chart.js';
import { Picture } from './views/picture.js';
import { STRINGS } from './strings.js';
import { TYPES } from './wire/messages.js';

const WORDS = STRINGS.instructor;
const CAMERAS = new Set(['camera', 'chase', 'station']);
const TELEMETRY = { throttle_rate: 200 };

export class TraineeView {
  /** @type {(() => void) | null} */
  #end = null;

  constructor(station) {
    this.station = station;
    this.chart = new ChartView(station);
    this.chart.tools.hidden = true; // the trainee plans
    this.chart.note.hidden = true;
    this.link = new Link(station);
    this.canvas = el('canvas', { className: 'picture', role: 'img', 'aria-label': WORDS.picture });
    this.picture = new Picture(station.bridge, this.canvas);
    this.choice = el('select', { 'aria-label': WORDS.view, onchange: () => this.#look() });
    this.element = el(
      'div',
      { className: 'instructor-views' },
      el('div', { className: 'view is-large' }, this.canvas),
      el('div', { className: 'view is-large' }, ...this.chart.element),
    );
  }

  /** Show another simulator.
   * @param {import('./wire/messages.js').Description} description
   */
  begin({ vehicles: [vehicle], views, scene }) {
    this.#end?.();
    this.picture.show('');
    const cameras = views.filter(({ kind }) => CAMERAS.has(kind));
    this.choice.replaceChildren(
      ...cameras.map((view) => el('option', { value: view.aboard_topic ?? view.topic }, titled(view))),
    );
    this.#look();
    this.chart.setLarge(true);
    this.chart.begin((path) => fetch(this.station.href(path)), vehicle.name, scene).catch(() => null);
    this.link.begin(vehicle, views);
    this.#end = this.station.bridge.subscribe(
      vehicle.telemetry,
      TYPES.Telemetry,
      (message) => this.chart.showTelemetry(message),
      TELEMETRY,
    );
  }

  #look() {
    this.picture.show(this.choice.value, { credit: 2 });
  }
}
