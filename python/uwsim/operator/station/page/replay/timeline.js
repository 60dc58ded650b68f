// The time line of a replay, in place of the controls that drive: time, events, the helm.
import { attempt, byId, capital, clockText, draw, first, pen } from '../dom.js';
import { html, signal } from '../vendor/preact.js';

/** Words before the values of an event, whose other names are said, or are left out.
 * @type {Record<string, string>}
 */
const BEFORE = {
  cause: 'cause:',
  elevation: 'tilt',
  positions: 'to',
  speeds: 'at',
  value: '=',
  why: 'because',
  z: 'height',
};
const UNSAID = new Set(['fault', 'holds', 'kind', 'lamp', 'mode', 'name', 'object', 'sonar', 'text', 'then', 'what']); // their values say enough
const INSET_PX = 8; // half of the slider's thumb
const HEIGHT_PX = 14; // of the events above it
const COLOURS = { command: '--text-soft', alarm: '--alarm', collision: '--warn' };

export class Timeline {
  now_s = 0;
  #shown_s = signal(0); // or the time to go to
  /** @type {{ value: import('../wire/messages.js').ReplayDescription | null }} */
  #flight = signal(null); // as described by the server
  #wanted_s = NaN; // the time to go to next
  #isSeeking = false;
  #isHeld = false; // whether the user is holding the slider

  constructor(station, telemetry) {
    this.station = station;
    this.element = byId('timeline');
    draw(this.element, () => this.#view(), [station, 'state', 'close']);
    this.plot = /** @type {any} */ (first(this.element, 'canvas'));
    station.addEventListener('state', () => this.#follow(station.state.time));
    telemetry.addEventListener('change', () => this.#follow(telemetry.stamp_s));
    new ResizeObserver(() => this.#draw()).observe(this.plot);
  }

  get #replay() {
    return this.#flight.value;
  }

  /** Show the time line of a session, if it is a replay.
   * @param {import('../wire/messages.js').Description} description
   */
  begin({ replay = null }) {
    this.#flight.value = replay;
    this.element.hidden = !replay;
    byId('station').classList.toggle('is-replay', replay !== null);
    this.#follow(this.station.state.time);
  }

  // The ends of the slider [s], in whole steps from 0.
  get #span_s() {
    const { start_s = 0, end_s = 1 } = this.#replay ?? {};
    return [Math.floor(start_s), Math.ceil(end_s)];
  }

  #view() {
    const { station } = this;
    const { events = [], end_s = 0 } = this.#replay ?? {};
    const [from_s, to_s] = this.#span_s;
    const mayNot = !station.isPilot;
    const text = `${clockText(this.#shown_s.value, 1)} / ${clockText(end_s, 1)}`;
    const hold = (isHeld) => () => (this.#isHeld = isHeld);
    return html`
      <div class="group">
        <button type="button" class="strong" disabled=${mayNot} onClick=${() => this.#playOrPause()}>
          ${station.state.paused ? 'Play' : 'Pause'}
        </button>
        <output class="reading" aria-label="Time, and the end of the flight">${text}</output>
      </div>
      <input type="range" aria-label="Time of the flight" aria-valuetext=${text} min=${from_s} max=${to_s} step="0.05"
        value=${this.#isHeld ? undefined : this.#shown_s.value} disabled=${mayNot}
        onInput=${({ target }) => this.seek(Number(target.value))} onPointerDown=${hold(true)} onPointerUp=${hold(false)} />
      <div class="group">
        <select aria-label="Go to an event" disabled=${mayNot} onChange=${({ target }) => this.#goTo(target)}>
          <option value="">${events.length === 1 ? '1 event' : `${events.length} events`}</option>
          ${events.map((each) => html`<option value=${each.time_s}>${clockText(each.time_s, 1)} ${happened(each)}</option>`)}
        </select>
        <button type="button" class="primary" disabled=${mayNot} onClick=${() => this.#takeHelm()}>Take the helm</button>
      </div>
      <canvas class="timeline-plot" role="img" aria-label="Events over time"
        onClick=${({ offsetX }) => this.seek(this.#timeAt(offsetX))} />
    `;
  }

  // Go to a time. While the server is moving to an earlier request's time, only the newest request is kept.
  async seek(time_s) {
    if (!this.#replay) return;
    const { start_s, end_s } = this.#replay;
    this.#wanted_s = Math.max(start_s, Math.min(end_s, time_s));
    this.#show(this.#wanted_s);
    if (this.#isSeeking) return;
    this.#isSeeking = true;
    while (Number.isFinite(this.#wanted_s)) {
      const wanted = this.#wanted_s;
      await attempt(this.station.control('seek', { time_s: wanted }));
      if (this.#wanted_s === wanted) this.#wanted_s = NaN;
    }
    this.#isSeeking = false;
  }

  #follow(time_s) {
    if (!this.#replay || !Number.isFinite(time_s)) return;
    this.now_s = time_s;
    if (!this.#isSeeking) this.#show(time_s);
  }

  #show(time_s) {
    this.#shown_s.value = time_s;
    this.#draw();
  }

  #draw() {
    const width = this.plot.clientWidth;
    if (!this.#replay || !width) return;
    const [from_s, to_s] = this.#span_s;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    [this.plot.width, this.plot.height] = [Math.round(width * ratio), HEIGHT_PX * ratio];
    const style = getComputedStyle(this.plot);
    const c = pen(this.plot);
    c.scale(ratio, ratio);
    const mark = (time_s, colour) => {
      const x = INSET_PX + ((time_s - from_s) / Math.max(to_s - from_s, 1e-9)) * (width - 2 * INSET_PX);
      c.fillStyle = style.getPropertyValue(colour);
      c.fillRect(x - 1, 0, 2, HEIGHT_PX);
    };
    for (const { time_s, kind } of this.#replay.events) mark(time_s, COLOURS[kind]);
    mark(this.#isSeeking ? this.#shown_s.value : this.now_s, '--accent');
  }

  #timeAt(px) {
    const [from_s, to_s] = this.#span_s;
    return from_s + ((px - INSET_PX) / (this.plot.clientWidth - 2 * INSET_PX)) * (to_s - from_s);
  }

  #playOrPause() {
    attempt(this.station.control(this.station.state.paused ? 'resume' : 'pause'));
  }

  #goTo(select) {
    if (select.value !== '') this.seek(Number(select.value));
    select.value = '';
  }

  #takeHelm() {
    attempt(this.station.control('helm'), 'You have the helm');
  }
}

/** An event of a recorded flight, such as "Fault rov – thruster, thruster v1".
 * @type {(event: import('../wire/messages.js').FlightEvent) => string}
 */
function happened({ name, vehicle, details }) {
  const values = details.map(({ name: of, text }) => (UNSAID.has(of) ? text : `${BEFORE[of] ?? of} ${text}`));
  return [capital(name.replaceAll('_', ' ')), vehicle, values.length ? `– ${values.join(', ')}` : '']
    .filter(Boolean)
    .join(' ');
}
