// The vehicle's failsafe: its action, the reason, its findings, and the button that takes back control.
import { attempt, el, write } from '../dom.js';
import { ALL_STOPPED } from '../wire/messages.js';

/** What each action does, and each cause is. @type {Record<string, string>} */
const SAID = {
  battery: 'the battery is low',
  go_on: 'continues with its last command',
  hold: 'holds its place by itself',
  leak: 'water is inside',
  return: 'is returning by itself',
  sensor: 'a sensor has failed',
  silence: 'it receives nothing',
  surface: 'is surfacing by itself',
  thruster: 'a thruster does not respond',
};

/** What a failsafe does, and why.
 * @type {(action: string, cause: string) => string}
 */
export const acts = (action, cause) =>
  `Failsafe: the vehicle ${SAID[action] ?? action}, because ${SAID[cause] ?? cause}.`;

export class Failsafe {
  #vehicle = '';

  constructor(station) {
    this.station = station;
    this.text = el('p', {});
    this.alarms = el('ul', {});
    this.button = el(
      'button',
      { type: 'button', id: 'take-back', title: 'Override the failsafe: it will not act on this cause again' },
      'Take back',
    );
    this.button.addEventListener('click', () =>
      attempt(
        station.command('override_failsafe', this.#vehicle),
        'The vehicle has been asked to accept commands again.',
      ),
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

  // Show the state from the telemetry; message is null before the first.
  show(message, isStale) {
    const { failsafe = '', failsafe_cause: cause = '' } = message ?? {};
    const alarms = (message?.alarms ?? []).filter((alarm) => alarm !== ALL_STOPPED);
    this.element.hidden = !failsafe && alarms.length === 0;
    this.element.classList.toggle('is-stale', isStale);
    this.element.dataset.kind = failsafe && failsafe !== 'go_on' ? 'steers' : 'tells';
    write(this.text, failsafe ? acts(failsafe, cause) : 'The vehicle has detected:');
    if (this.#listed !== alarms.join('\n')) this.alarms.replaceChildren(...alarms.map((alarm) => el('li', {}, alarm)));
    this.button.hidden = !failsafe;
    this.button.disabled = !this.station.isPilot;
  }

  get #listed() {
    return [...this.alarms.children].map(({ textContent }) => textContent).join('\n');
  }
}
