// The vehicle's failsafe: its action, the reason, its findings, and the button that takes back control.
import { attempt, el, write } from '../dom.js';
import { ALL_STOPPED } from '../wire/messages.js';
import { acts, said } from '../said.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.failsafe;

export class Failsafe {
  #vehicle = '';

  constructor(station) {
    this.station = station;
    this.text = el('p', {});
    this.alarms = el('ul', {});
    this.button = el('button', { type: 'button', id: 'take-back', tip: WORDS.tip }, WORDS.takeBack);
    this.button.addEventListener('click', () =>
      attempt(station.command('override_failsafe', this.#vehicle), WORDS.asked),
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
    const alarms = (message?.alarms ?? []).filter((alarm) => alarm !== ALL_STOPPED).map(said);
    this.element.hidden = !failsafe && alarms.length === 0;
    this.element.classList.toggle('is-stale', isStale);
    this.element.dataset.kind = failsafe && failsafe !== 'go_on' ? 'steers' : 'tells';
    write(this.text, failsafe ? acts(failsafe, cause) : WORDS.notices);
    if (this.#listed !== alarms.join('\n')) this.alarms.replaceChildren(...alarms.map((alarm) => el('li', {}, alarm)));
    this.button.hidden = !failsafe;
    this.button.disabled = !this.station.isPilot;
  }

  get #listed() {
    return [...this.alarms.children].map(({ textContent }) => textContent).join('\n');
  }
}
