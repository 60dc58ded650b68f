// The vehicle's failsafe: its action, the reason, its findings, and the button that takes back control.
import { attempt } from '../dom.js';
import { html } from '../vendor/preact.js';
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

// vehicle: its name. message: the newest telemetry, null before the first.
export function failsafe(station, vehicle, message, isStale) {
  const { failsafe: action = '', failsafe_cause: cause = '' } = message ?? {};
  const alarms = (message?.alarms ?? []).filter((alarm) => alarm !== ALL_STOPPED);
  const takeBack = () =>
    attempt(station.command('override_failsafe', vehicle), 'The vehicle has been asked to accept commands again.');
  return html`
    <section id="failsafe" class="failsafe ${isStale ? 'is-stale' : ''}" hidden=${!action && alarms.length === 0}
      data-kind=${action && action !== 'go_on' ? 'steers' : 'reports'}>
      <div role="alert">
        <p>${action ? acts(action, cause) : 'The vehicle has detected:'}</p>
        <ul>${alarms.map((alarm) => html`<li>${alarm}</li>`)}</ul>
      </div>
      <button type="button" id="take-back" title="Override the failsafe: it will not act on this cause again"
        hidden=${!action} disabled=${!station.isPilot} onClick=${takeBack}>Take back</button>
    </section>
  `;
}
