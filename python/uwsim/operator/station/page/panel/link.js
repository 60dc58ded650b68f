// The quality of the link between station and vehicle. In a scenario without a link, it is shown only while a fault
// has cut the vehicle off.
import { fixed } from '../dom.js';
import { subscribed } from '../telemetry.js';
import { html, signal } from '../vendor/preact.js';
import { TYPES } from '../wire/messages.js';
import { valueRow } from './rows.js';

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
  #ends = /** @type {(() => void)[]} */ ([]);
  #views = []; // those of describe
  #message = signal(null); // the last
  #interval = 0; // between the last two
  #isAboard = signal(false);
  /** @type {((isAboard: boolean) => void) | undefined} */
  onAboard; // called when the operator switches to the vehicle's own view

  constructor(station) {
    this.station = station;
  }

  begin({ link }, views) {
    for (const end of this.#ends) end();
    this.#views = views;
    this.#message.value = null;
    this.#interval = 0;
    if (this.#isAboard.value && !this.#hasTruth) this.#show(false);
    this.#ends = subscribed(this.station.bridge, link, TYPES.Link, (message) => this.#receive(message));
  }

  get #hasTruth() {
    return this.#views.some((view) => view.aboard_topic);
  }

  #show(isAboard) {
    this.#isAboard.value = isAboard;
    this.onAboard?.(isAboard);
  }

  #receive(message) {
    const before_s = this.#message.value?.silence_at_station ?? 0;
    if (message.silence_at_station < before_s) this.#interval = before_s;
    this.#message.value = message;
  }

  view() {
    const message = this.#message.value;
    const isPlain = message?.modem === NONE;
    const isBad =
      message &&
      (message.fault_loss > 0 ||
        message.quality < POOR ||
        message.silence_at_station > Math.max(SILENT_S, LATE * this.#interval));
    const note = !message ? '' : isPlain ? 'down' : message.modem + faultText(message.fault_loss);
    const isHidden = message ? isPlain && !(message.fault_loss > 0) : !this.#views.some((view) => view.link);
    return html`
      <section id="link" class="link" data-level=${message && (isBad ? 'warn' : 'good')} hidden=${isHidden}>
        <h2>Link<small>${note}</small></h2>
        <dl class="values">
          ${VALUES.map(([name, unit, read]) => valueRow(name, unit, message && !isPlain ? read(message) : '–'))}
        </dl>
        <label class="aboard" hidden=${!this.#hasTruth}>
          <input type="checkbox" checked=${this.#isAboard.value} onChange=${({ target }) => this.#show(target.checked)} />
          ${' '}Show what the vehicle sees
        </label>
      </section>
    `;
  }
}
