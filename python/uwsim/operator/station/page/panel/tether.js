// The vehicle's tether: length out, tensions, the scale of its colours, turns about obstacles, and the winch.
import { attempt, byId, fixed } from '../dom.js';
import { subscribed } from '../telemetry.js';
import { html, signal } from '../vendor/preact.js';
import { valueRow } from './rows.js';

const KEPT = 0.1; // of the winch's strongest tension, that the field begins with
/** @type {[string, string, number][]} */
const VALUES = [
  ['Out', 'm', 1],
  ['Rate out', 'm/s', 2],
  ['Tension at the winch', 'N', 1],
  ['Tension at the vehicle', 'N', 1],
];

export class TetherPanel {
  /** @type {(() => void)[]} */
  #ends = [];
  #vehicle = '';
  /** @type {{ value: import('../wire/messages.js').TetherDescription | null }} */
  #tether = signal(null);
  #state = signal([]); // VALUES, and whether it is broken
  #turns = signal([]);

  constructor(station) {
    this.station = station;
  }

  begin({ name, tether }) {
    for (const end of this.#ends) end();
    this.#vehicle = name;
    [this.#tether.value, this.#state.value, this.#turns.value] = [tether ?? null, [], []];
    const listen = (topic, kept) =>
      subscribed(this.station.bridge, topic, 'std_msgs/Float64MultiArray', ({ data }) => (kept.value = [...data]));
    this.#ends = [...listen(tether?.tension, this.#state), ...listen(tether?.turns, this.#turns)];
  }

  view() {
    const [tether, state] = [this.#tether.value, this.#state.value];
    if (!tether) return html`<section id="tether" hidden />`;
    const { fastest_m_s: fastest, strongest_n: strongest } = tether;
    const isTangled = this.#turns.value.some((turn) => turn !== 0);
    const mayNot = !this.station.isPilot;
    const wind = (args) => attempt(this.station.command('set_winch', this.#vehicle, args));
    const button = (name, text, args) =>
      html`<button type="button" id="winch-${name}" disabled=${mayNot} onClick=${() => wind(args())}>${text}</button>`;
    return html`
      <section id="tether" class="tether" data-level=${state[4] || isTangled ? 'warn' : ''}>
        <h2>Tether<small role="status">${state[4] ? 'broken' : isTangled ? 'goes round an obstacle' : ''}</small></h2>
        <dl class="values">${VALUES.map(([name, unit, digits], k) => valueRow(name, unit, fixed(state[k], digits)))}</dl>
        <div class="scale" title="Colours of the tether in the 3D view and on the chart, by tension (logarithmic)">
          1 N<i /><span>${Math.round(tether.breaking_load_n)} N breaks it</span>
        </div>
        <div class="winch" role="group" aria-label="Winch" hidden=${fastest === null}>
          ${button('out', 'Pay out', () => ({ rate_m_s: fastest }))}
          ${button('hold', 'Hold', () => ({}))}
          ${button('in', 'Recover', () => ({ rate_m_s: -(fastest ?? 0) }))}
          ${button('keep', 'Keep tension', () => ({ tension_n: Number(byId('winch-kept').value) }))}
          <input key=${this.#vehicle} type="number" id="winch-kept" min="0" max=${strongest ?? ''} step="any"
            defaultValue=${KEPT * (strongest ?? 0)} aria-label="Tension to keep, N" disabled=${mayNot} />
        </div>
      </section>
    `;
  }
}
