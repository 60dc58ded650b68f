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
    const last = this.#last;
    const was = this.entries[0];
    const now = {
      time_s,
      count: message.collisions ?? 0,
      contact: contact?.name ?? '',
      note: message.hold_note ?? '',
      failsafe: message.failsafe ? acts(message.failsafe, message.failsafe_cause ?? '') : '',
      alarms: [...(message.alarms ?? [])],
      flags: Object.keys(FLAGS).filter((field) => message[field]),
    };
    this.#last = now;
    if (!last || time_s < last.time_s) {
      const hadAny = this.entries.length > 0; // from a different run, or from before a restart
      [this.entries, this.collisions] = [[], 0];
      return hadAny;
    }
    const add = (text) => {
      this.entries = [{ time_s, text }, ...this.entries].slice(0, LONGEST);
    };
    if (now.count > last.count) {
      this.collisions += now.count - last.count;
      add('Collision');
    }
    if (now.contact && now.contact !== last.contact) add(`Contact ahead: ${now.contact.replaceAll('_', ' ')}`);
    for (const field of now.flags) if (!last.flags.includes(field)) add(FLAGS[field]);
    for (const alarm of now.alarms) if (!last.alarms.includes(alarm)) add(alarm);
    if (now.failsafe && now.failsafe !== last.failsafe) add(now.failsafe);
    if (now.note && now.note !== last.note) add(now.note);
    return this.entries[0] !== was;
  }

  acknowledge() {
    this.collisions = 0;
  }
}
