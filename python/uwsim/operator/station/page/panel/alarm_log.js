// The alarms of this session with their times, and the collisions that have not been acknowledged yet.
import { acts } from './failsafe.js';

const LONGEST = 200;
const FLAGS = { range_warning: 'Range', proximity_warning: 'Near the bed' };

export class AlarmLog {
  entries = []; // { time_s, text }, newest first
  collisions = 0; // since the last acknowledgement
  /** @type {Record<string, any> | null} */
  #last = null;

  /** Process the telemetry at a simulated time; return whether the entries have changed. contact: see Telemetry.
   * @param {Partial<import('../wire/messages.js').Telemetry>} message
   * @param {number} time_s
   * @param {{ name: string } | null} contact
   */
  update(message, time_s, contact = null) {
    const { collisions: count = 0, alarms = [], failsafe = '', failsafe_cause: cause = '' } = message;
    const texts = [
      contact ? `Contact ahead: ${contact.name.replaceAll('_', ' ')}` : '',
      ...Object.keys(FLAGS).map((field) => message[field] && FLAGS[field]),
      ...alarms,
      failsafe && acts(failsafe, cause),
      message.hold_note,
    ].filter(Boolean);
    const last = this.#last;
    this.#last = { time_s, count, texts };
    if (!last || time_s < last.time_s) {
      const hadAny = this.entries.length > 0; // from a different run, or from before a restart
      [this.entries, this.collisions] = [[], 0];
      return hadAny;
    }
    const hits = Math.max(0, count - last.count);
    this.collisions += hits;
    const added = [hits ? 'Collision' : '', ...texts.filter((text) => !last.texts.includes(text))].filter(Boolean);
    if (added.length) {
      const newest = added.toReversed().map((text) => ({ time_s, text }));
      this.entries = [...newest, ...this.entries].slice(0, LONGEST);
    }
    return added.length > 0;
  }

  acknowledge() {
    this.collisions = 0;
  }
}
