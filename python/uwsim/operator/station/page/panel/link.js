// The quality of the link between station and vehicle. In a scenario without a link, it is shown only while a fault
// has cut the vehicle off.
import { el, fixed, write } from '../dom.js';
import { TYPES } from '../wire/messages.js';

const POOR = 0.8; // quality
const SILENT_S = 5;
const LATE = 2.5; // over a slow modem, in multiples of the interval between the last two messages
const NONE = 'none';
/** @type {[string, string, (message: import('../wire/messages.js').Link) => string][]} */
const VALUES = [
  ['Quality', '%', (m) => fixed(100 * m.quality, 0)],
  ['Delay', 'ms', (m) => fixed(1000 * m.delay, 0)],
  ['Silent here', 's', (m) => fixed(m.silence_at_station, 1)],
  ['Silent there', 's', (m) => fixed(m.silence, 1)],
  ['SNR', 'dB', (m) => fixed(m.snr, 0)],
  ['Lost', '', (m) => `${m.lost} of ${m.sent}`],
];

function faultText(loss) {
  if (!(loss > 0)) return '';
  return loss >= 1 ? ': blackout' : `: a fault drops ${fixed(100 * loss, 0)} %`;
}

export class Link {
  /** @type {(() => void) | null} */
  #end = null;
  #silence = 0; // from the last message
  #interval = 0;
  /** @type {((isAboard: boolean) => void) | undefined} */
  onAboard; // called when the operator switches to the vehicle's own view

  constructor(station) {
    this.station = station;
    this.note = el('small');
    this.aboard = el('input', { type: 'checkbox' });
    this.aboard.addEventListener('change', () => this.onAboard?.(this.aboard.checked));
    this.truth = el('label', { className: 'aboard', hidden: true }, this.aboard, ' ', 'Show what the vehicle sees');
    this.values = VALUES.map(() => el('span', {}, '–'));
    this.element = el(
      'section',
      { id: 'link', className: 'link', hidden: true },
      el('h2', {}, 'Link', this.note),
      el(
        'dl',
        { className: 'values' },
        ...VALUES.map(([name, unit], k) =>
          el(
            'div',
            {},
            el('dt', {}, name),
            el('dd', {}, this.values[k], unit ? el('span', { className: 'unit' }, unit) : null),
          ),
        ),
      ),
      this.truth,
    );
  }

  // views: those of describe.
  begin({ link }, views) {
    this.#end?.();
    this.#end = null;
    this.element.hidden = !views.some((view) => view.link);
    this.truth.hidden = !views.some((view) => view.aboard_topic);
    if (this.truth.hidden && this.aboard.checked) {
      this.aboard.checked = false;
      this.onAboard?.(false);
    }
    for (const value of this.values) write(value, '–');
    this.#silence = this.#interval = 0;
    write(this.note, '');
    if (link) this.#end = this.station.bridge.subscribe(link, TYPES.Link, (message) => this.#show(message));
  }

  #show(message) {
    const isPlain = message.modem === NONE;
    this.element.hidden = isPlain && !(message.fault_loss > 0);
    for (const [k, [, , read]] of VALUES.entries()) write(this.values[k], isPlain ? '–' : read(message));
    if (message.silence_at_station < this.#silence) this.#interval = this.#silence;
    this.#silence = message.silence_at_station;
    const isBad =
      message.fault_loss > 0 || message.quality < POOR || this.#silence > Math.max(SILENT_S, LATE * this.#interval);
    this.element.dataset.level = isBad ? 'warn' : 'good';
    write(this.note, isPlain ? 'down' : message.modem + faultText(message.fault_loss));
  }
}
