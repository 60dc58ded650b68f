// The vehicle's failsafe: its action, the reason, its findings, and the button that takes control back.
import { attempt, el, write } from '../dom.js';
import { ALL_STOPPED } from '../wire/messages.js';

const DOING = {
  hold: 'holds its place by itself',
  surface: 'surfaces by itself',
  return: 'returns by itself',
  go_on: 'goes on as last told',
};
const CAUSES = {
  silence: 'it hears nothing',
  battery: 'the battery is low',
  leak: 'water is inside',
  thruster: 'a thruster does not obey',
  sensor: 'a sensor fails',
};

export class Failsafe {
  #vehicle = '';

  constructor(station) {
    this.station = station;
    this.text = el('p', {});
    this.alarms = el('ul', {});
    this.button = el(
      'button',
      { type: 'button', id: 'take-back', title: 'Override the failsafe: it acts no more for this cause' },
      'Take back',
    );
    this.button.addEventListener('click', () =>
      attempt(station.command('override_failsafe', this.#vehicle), 'The vehicle is asked to obey again.'),
    );
    this.element = el(
      'section',
      { id: 'failsafe', className: 'failsafe', hidden: true },
      el('div', { role: 'alert' }, this.text, this.alarms),
      this.button,
    );
  }

  begin(vehicle) {
    this.#vehicle = vehicle.name;
  }

  // Show the state from the telemetry, which servers of other versions may not send.
  show(message, isStale) {
    const { failsafe = '', failsafe_cause: cause = '' } = message ?? {};
    const alarms = (message?.alarms ?? []).filter((alarm) => alarm !== ALL_STOPPED);
    this.element.hidden = !failsafe && alarms.length === 0;
    this.element.classList.toggle('is-stale', isStale);
    this.element.dataset.kind = failsafe && failsafe !== 'go_on' ? 'steers' : 'tells';
    write(
      this.text,
      failsafe
        ? `Failsafe: the vehicle ${DOING[failsafe] ?? failsafe}, because ${CAUSES[cause] ?? cause}.`
        : 'The vehicle notices:',
    );
    if (this.#listed !== alarms.join('\n')) this.alarms.replaceChildren(...alarms.map((alarm) => el('li', {}, alarm)));
    this.button.hidden = !failsafe;
    this.button.disabled = !this.station.isPilot;
  }

  get #listed() {
    return [...this.alarms.children].map(({ textContent }) => textContent).join('\n');
  }
}
