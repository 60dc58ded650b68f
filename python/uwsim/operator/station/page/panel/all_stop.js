// All stop: a button and a key that set it from any page, and a button with which the pilot releases it.
import { attempt, byId, el, toast, write } from '../dom.js';
import { ALL_STOPPED } from '../wire/messages.js';

export class AllStop {
  #vehicle = '';
  #wanted = ''; // the vehicle to be stopped, until a server has confirmed it
  #isAsking = false;
  #wasSet = false;

  constructor(station, pilot) {
    this.station = station;
    this.pilot = pilot;
    this.lamp = byId('all-stop');
    this.lamp.addEventListener('click', () => this.press());
    this.text = el('p', {});
    this.button = el('button', { type: 'button', id: 'end-stop', onclick: () => this.#release() }, 'Release all stop');
    this.element = el(
      'section',
      { id: 'stopped', className: 'failsafe', hidden: true },
      el('div', { role: 'alert' }, this.text),
      this.button,
    );
    this.element.dataset.kind = 'steers';
    station.addEventListener('state', () => this.#wanted && !this.#isAsking && this.#send());
  }

  begin(vehicle) {
    if (vehicle.name !== this.#vehicle) this.#wasSet = false;
    this.#vehicle = vehicle.name;
  }

  // Stop the vehicle. Every press is sent, and repeated until it is answered.
  press() {
    if (!this.station.isRunning || !this.#vehicle || this.station.description?.replay) return;
    this.pilot.stop();
    this.#wanted = this.#vehicle;
    this.#send();
  }

  // Show the state from the telemetry.
  show(message, isStale) {
    const isSet = (message?.alarms ?? []).includes(ALL_STOPPED);
    if (isSet && !this.#wasSet) this.pilot.release(); // a held key must not move the vehicle after the release
    this.#wasSet = isSet;
    this.element.hidden = !isSet;
    this.element.classList.toggle('is-stale', isStale);
    this.lamp.setAttribute('aria-pressed', String(isSet));
    write(
      this.text,
      `All stop: the thrusters are off, and nothing moves the vehicle.${this.station.isPilot ? '' : ' The pilot may release it.'}`,
    );
    this.button.disabled = !this.station.isPilot;
  }

  async #send() {
    const vehicle = this.#wanted;
    this.#isAsking = true;
    try {
      const { success, message } = await this.station.allStop(vehicle, true);
      if (success !== false) this.#wanted = '';
      toast(
        message || (success === false ? 'The simulator refused.' : 'All stop'),
        success === false ? 'error' : 'info',
      );
    } catch (error) {
      if (this.station.connected) this.#wanted = ''; // this server does not support it: efforts are zero there
      toast(error.message, 'error');
    } finally {
      this.#isAsking = false;
    }
  }

  #release() {
    this.#wanted = '';
    attempt(this.station.allStop(this.#vehicle, false), 'All stop is released: press the key again.');
  }
}
