// Pictures of the chosen scenario: what its vehicle sees, and the scenario from above.
import { el } from './dom.js';

const LEGEND = {
  station: 'Station',
  start: 'Vehicle at its start',
  obstacle: 'Obstacles',
  area: 'Area to survey',
};

export class Preview {
  #shown = '';
  #edition = 0; // of the scenarios' files

  constructor() {
    this.image = el('img', {
      alt: '',
      onload: () => this.#show(true),
      onerror: () => this.#show(false),
    });
    const legend = Object.entries(LEGEND).map(([kind, text]) =>
      el('li', {}, el('span', { className: `mark mark-${kind}`, 'aria-hidden': 'true' }), text),
    );
    this.still = el('img', {
      alt: '',
      hidden: true,
      onload: () => (this.still.hidden = false),
      onerror: () => (this.still.hidden = true),
    });
    this.element = el(
      'figure',
      { className: 'preview', hidden: true },
      this.still,
      this.image,
      el('figcaption', {}, el('p', {}, 'From above, north up'), el('ul', {}, ...legend)),
    );
  }

  // Show the pictures of a scenario; '' for none. href(suffix): the address of one. What is seen from above
  // stays until the next has loaded.
  show(scenario, href) {
    if (scenario === this.#shown) return;
    this.#shown = scenario;
    if (!scenario) {
      this.#show(false);
      return;
    }
    this.still.hidden = true;
    this.still.alt = `${scenario}, as its vehicle sees it`;
    this.image.alt = `${scenario} from above: depths, obstacles, station and start`;
    this.still.src = this.#newest(href('.jpg'));
    this.image.src = this.#newest(href('.png'));
  }

  #newest(url) {
    return this.#edition ? `${url}${url.includes('?') ? '&' : '?'}edition=${this.#edition}` : url;
  }

  // Ask for the picture again, as the scenario's file has changed.
  forget() {
    this.#shown = '';
    this.#edition += 1;
  }

  #show(isShown) {
    this.element.hidden = !isShown || this.#shown === '';
  }
}
