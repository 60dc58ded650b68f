// The controls over a sonar's large picture: range, gain, palette, freeze, and the reading at the cursor.
import { capital, el, write } from '../dom.js';
import { inUnit, unitName } from '../units.js';
import { PALETTES } from './sonar_geometry.js';

const GAIN_STEP_DB = 3;
const GAIN_MAX_DB = 24;

// Events: 'change'. reach_m: the range shown, 0 for automatic. surface: the element that the cursor points at.
export class SonarTools extends EventTarget {
  #ranges;
  #frozenMs = 0;
  #texts = {};
  reach_m = 0;
  gain_db = 0;
  palette = 'amber';

  // ranges: those offered, in metres, ascending, 0 for automatic. hasLevels: whether gain and palette apply.
  constructor(surface, { ranges, hasLevels }) {
    super();
    this.surface = surface;
    this.setRanges(ranges);
    this.reading = el(
      'output',
      { className: 'sonar-reading', 'aria-label': 'Range and bearing at the cursor' },
      'Point at the picture',
    );
    this.frozen = el('p', { className: 'sonar-frozen', role: 'status', hidden: true });
    const freeze = el('button', { type: 'button', 'aria-pressed': 'false' }, 'Freeze');
    freeze.addEventListener('click', () => this.freeze(!this.isFrozen));
    this.#texts.freeze = freeze;
    this.element = el(
      'div',
      { className: 'sonar-tools', role: 'group', 'aria-label': 'Sonar picture' },
      ...this.#stepper('Range', 'range', (by) => this.#stepRange(by)),
      ...(hasLevels ? this.#stepper('Gain', 'gain', (by) => this.#stepGain(by)) : []),
      hasLevels ? this.#palettes() : null,
      freeze,
      this.reading,
    );
    surface.addEventListener('pointermove', (event) => this.#point(event));
    surface.addEventListener('pointerleave', () => this.#point(null));
    setInterval(() => this.isFrozen && this.#show(), 1000);
    this.#show();
  }

  get isFrozen() {
    return this.#frozenMs > 0;
  }

  setRanges(ranges) {
    this.#ranges = ranges;
    if (!ranges.includes(this.reach_m)) this.reach_m = ranges.includes(0) ? 0 : ranges.at(-1);
  }

  freeze(isFrozen) {
    if (isFrozen === this.isFrozen) return;
    this.#frozenMs = isFrozen ? performance.now() : 0;
    this.#changed();
  }

  // The cursor in the surface's pixels, or null.
  /** @type {[number, number] | null} */
  at = null;

  // found: { range_m, bearing_rad } at the cursor, or null.
  read(found) {
    write(this.reading, found ? readingText(found) : 'Point at the picture');
  }

  #stepper(title, name, step) {
    const value = el('output', { className: 'sonar-value', 'aria-label': title });
    this.#texts[name] = value;
    const button = (text, label, by) =>
      el('button', { type: 'button', 'aria-label': `${label} ${title.toLowerCase()}`, onclick: () => step(by) }, text);
    return [el('span', { 'aria-hidden': 'true' }, title), button('−', 'Less', -1), value, button('+', 'More', 1)];
  }

  #palettes() {
    const options = Object.keys(PALETTES).map((name) => el('option', { value: name }, capital(name)));
    const select = el('select', { 'aria-label': 'Palette' }, ...options);
    select.addEventListener('change', () => {
      this.palette = select.value;
      select.blur();
      this.#changed();
    });
    return select;
  }

  #stepRange(by) {
    const k = this.#ranges.indexOf(this.reach_m) + by;
    this.reach_m = this.#ranges[Math.min(Math.max(k, 0), this.#ranges.length - 1)];
    this.#changed();
  }

  #stepGain(by) {
    this.gain_db = Math.min(Math.max(this.gain_db + by * GAIN_STEP_DB, -GAIN_MAX_DB), GAIN_MAX_DB);
    this.#changed();
  }

  #point(event) {
    this.at = event && [event.offsetX, event.offsetY];
    this.dispatchEvent(new Event('change'));
  }

  #changed() {
    this.#show();
    this.dispatchEvent(new Event('change'));
  }

  #show() {
    const { range, gain, freeze } = this.#texts;
    write(range, this.reach_m ? `${+inUnit(this.reach_m).toFixed(1)} ${unitName()}` : 'auto');
    if (gain) write(gain, `${this.gain_db > 0 ? '+' : ''}${this.gain_db} dB`);
    freeze.setAttribute('aria-pressed', String(this.isFrozen));
    this.frozen.hidden = !this.isFrozen;
    write(this.frozen, `Frozen for ${Math.round((performance.now() - this.#frozenMs) / 1000)} s`);
  }
}

export function readingText({ range_m, bearing_rad }) {
  return `${inUnit(range_m).toFixed(1)} ${unitName()}, ${bearingText(bearing_rad)}`;
}

// A bearing from the bow, such as '34° starboard'.
export function bearingText(bearing_rad) {
  const degrees = Math.round((Math.abs(bearing_rad) * 180) / Math.PI);
  return degrees === 0 ? 'ahead' : `${degrees}° ${bearing_rad < 0 ? 'port' : 'starboard'}`;
}
