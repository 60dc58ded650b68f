// All stop: a button and a key that set it from any page, and a button with which the pilot releases it.
import { attempt, toast } from '../dom.js';
import { html } from '../vendor/preact.js';
import { ALL_STOPPED } from '../wire/messages.js';

export class AllStop {
  #vehicle = '';
  #wanted = ''; // the vehicle to be stopped, until a server has confirmed it
  #isAsking = false;
  #isSet = false;

  constructor(station, pilot) {
    this.station = station;
    this.pilot = pilot;
    station.addEventListener('state', () => this.#wanted && !this.#isAsking && this.#send());
  }

  begin(vehicle) {
    if (vehicle.name !== this.#vehicle) this.#isSet = false;
    this.#vehicle = vehicle.name;
  }

  // Stop the vehicle. Every press is sent, and repeated until it is answered.
  press() {
    if (!this.station.isRunning || !this.#vehicle || this.station.description?.replay) return;
    this.pilot.stop();
    this.#wanted = this.#vehicle;
    this.#send();
  }

  // Follow the telemetry.
  hear(message) {
    const isSet = (message?.alarms ?? []).includes(ALL_STOPPED);
    if (isSet && !this.#isSet) this.pilot.release(); // a held key must not move the vehicle after the release
    this.#isSet = isSet;
  }

  view(isStale) {
    const { isPilot } = this.station;
    return html`
      <section id="stopped" class="failsafe ${isStale ? 'is-stale' : ''}" data-kind="steers" hidden=${!this.#isSet}>
        <div role="alert">
          <p>All stop: the thrusters are off, and nothing moves the vehicle.${isPilot || ' The pilot may release it.'}</p>
        </div>
        <button type="button" id="end-stop" disabled=${!isPilot} onClick=${() => this.#release()}>
          Release all stop
        </button>
      </section>
    `;
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
