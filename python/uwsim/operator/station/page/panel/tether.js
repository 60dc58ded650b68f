// The vehicle's tether: length out, tensions, the scale of its colours, turns about obstacles, and the winch.
import { attempt, el, fixed, write } from '../dom.js';

const KEPT = 0.1; // of the winch's strongest tension, that the field begins with

const button = (name, text, act) => el('button', { type: 'button', id: `winch-${name}`, onclick: act }, text);

export class TetherPanel {
  /** @type {(() => void)[]} */
  #ends = [];
  #vehicle = '';
  /** @type {import('../wire/messages.js').TetherDescription | null} */
  #tether = null;
  #turns = [];
  #state = [];

  constructor(station) {
    this.station = station;
    this.note = el('small', { role: 'status' });
    this.values = [
      ['Out', 'm'],
      ['Rate out', 'm/s'],
      ['Tension at the winch', 'N'],
      ['Tension at the vehicle', 'N'],
    ].map(([name, unit]) => ({ name, unit, element: el('span', {}, '–') }));
    this.kept = el('input', { type: 'number', min: '0', step: 'any', 'aria-label': 'Tension to keep, N' });
    this.buttons = [
      button('out', 'Pay out', () => this.#wind({ rate_m_s: this.#tether?.fastest_m_s })),
      button('hold', 'Hold', () => this.#wind({})),
      button('in', 'Recover', () => this.#wind({ rate_m_s: -(this.#tether?.fastest_m_s ?? 0) })),
      button('keep', 'Keep tension', () => this.#wind({ tension_n: Number(this.kept.value) })),
    ];
    this.winch = el('div', { className: 'winch', role: 'group', 'aria-label': 'Winch' }, ...this.buttons, this.kept);
    this.most = el('span');
    this.element = el(
      'section',
      { id: 'tether', className: 'tether', hidden: true },
      el('h2', {}, 'Tether', this.note),
      el(
        'dl',
        { className: 'values' },
        ...this.values.map(({ name, element, unit }) =>
          el('div', {}, el('dt', {}, name), el('dd', {}, element, el('span', { className: 'unit' }, unit))),
        ),
      ),
      el(
        'div',
        {
          className: 'scale',
          title: 'Colours of the tether in the 3D view and on the chart, by tension (logarithmic)',
        },
        '1 N',
        el('i'),
        this.most,
      ),
      this.winch,
    );
    station.addEventListener('state', () => this.#enable());
  }

  begin({ name, tether }) {
    for (const end of this.#ends) end();
    this.#ends = [];
    [this.#vehicle, this.#tether, this.#turns, this.#state] = [name, tether ?? null, [], []];
    this.element.hidden = !tether;
    if (!tether) return;
    this.winch.hidden = tether.fastest_m_s === null;
    this.kept.max = String(tether.strongest_n ?? '');
    this.kept.value = String(KEPT * (tether.strongest_n ?? 0));
    write(this.most, `${Math.round(tether.breaking_load_n)} N breaks it`);
    for (const { element } of this.values) write(element, '–');
    write(this.note, '');
    const listen = (topic, show) =>
      this.#ends.push(
        this.station.bridge.subscribe(topic, 'std_msgs/Float64MultiArray', ({ data }) => show([...data])),
      );
    listen(tether.tension, (data) => this.#show(data.slice(0, 5)));
    if (tether.turns) listen(tether.turns, (turns) => this.#warn(turns));
    this.#enable();
  }

  #wind(args) {
    return attempt(this.station.command('set_winch', this.#vehicle, args));
  }

  #show(state) {
    this.#state = state;
    this.values.forEach(({ element }, k) => write(element, fixed(state[k], k === 1 ? 2 : 1)));
    this.#warn(this.#turns);
  }

  #warn(turns) {
    this.#turns = turns;
    const isTangled = turns.some((turn) => turn !== 0);
    write(this.note, this.#state[4] ? 'broken' : isTangled ? 'goes round an obstacle' : '');
    this.element.dataset.level = this.#state[4] || isTangled ? 'warn' : '';
  }

  #enable() {
    for (const each of [...this.buttons, this.kept]) each.disabled = !this.station.isPilot;
  }
}
