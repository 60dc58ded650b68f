// Pictures of the chosen scenario: what its vehicle sees, and the scenario from above.
import { html, signal } from './vendor/preact.js';

const LEGEND = {
  station: 'Station',
  start: 'Vehicle at its start',
  obstacle: 'Obstacles',
  area: 'Area to survey',
};

export class Preview {
  #shown = signal({ scenario: '', still: '', above: '' });
  #loaded = signal({ still: false, above: false });
  #edition = 0; // of the scenarios' files

  // Show the pictures of a scenario; '' for none. href(suffix): the address of one. What is seen from above
  // stays until the next has loaded.
  show(scenario, href) {
    const { scenario: before, still, above } = this.#shown.value;
    if (scenario === before) return;
    const newest = (url) => (this.#edition ? `${url}${url.includes('?') ? '&' : '?'}edition=${this.#edition}` : url);
    if (scenario) this.#shown.value = { scenario, still: newest(href('.jpg')), above: newest(href('.png')) };
    else this.#shown.value = { scenario, still, above };
    this.#loaded.value = { still: false, above: this.#loaded.value.above && scenario !== '' };
  }

  // Ask for the picture again, as the scenario's file has changed.
  forget() {
    this.#shown.value = { ...this.#shown.value, scenario: '' };
    this.#edition += 1;
  }

  view() {
    const { scenario, still, above } = this.#shown.value;
    const loaded = this.#loaded.value;
    const load = (name, is) => () => (this.#loaded.value = { ...this.#loaded.value, [name]: is });
    const image = (name, src, alt, isHidden) => html`
      <img src=${src || undefined} alt=${alt} hidden=${isHidden} onLoad=${load(name, true)} onError=${load(name, false)} />
    `;
    return html`
      <figure class="preview" hidden=${!loaded.above}>
        ${image('still', still, `${scenario}, as its vehicle sees it`, !loaded.still)}
        ${image('above', above, `${scenario} from above: depths, obstacles, station and start`, false)}
        <figcaption>
          <p>From above, north up</p>
          <ul>
            ${Object.entries(LEGEND).map(
              ([kind, text]) => html`<li><span class="mark mark-${kind}" aria-hidden="true" />${text}</li>`,
            )}
          </ul>
        </figcaption>
      </figure>
    `;
  }
}
