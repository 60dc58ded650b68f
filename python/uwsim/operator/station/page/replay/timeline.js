// The time line of a replay, in place of the controls that drive: time, events, the helm.
import { attempt, byId, capital, clockText, el, pen, write } from '../dom.js';

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
const option = (value, text) => el('option', { value }, text);

export class Timeline {
  now_s = 0;
  /** @type {import('../wire/messages.js').ReplayDescription | null} */
  #replay = null; // as described by the server
  #wanted_s = NaN; // the time to go to next
  #isSeeking = false;
  #isHeld = false; // whether the user is holding the slider

  constructor(station, telemetry, panel) {
    this.station = station;
    this.panel = panel;
    this.play = el('button', { type: 'button', className: 'strong', onclick: () => this.#playOrPause() });
    this.time = el('output', { className: 'reading', 'aria-label': 'Time, and the end of the flight' });
    this.slider = el('input', { type: 'range', 'aria-label': 'Time of the flight', step: '0.05' });
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    this.slider.addEventListener('pointerdown', () => (this.#isHeld = true));
    this.slider.addEventListener('pointerup', () => (this.#isHeld = false));
    this.events = el('select', { 'aria-label': 'Go to an event', onchange: () => this.#goToEvent() });
    this.helm = el(
      'button',
      { type: 'button', className: 'primary', onclick: () => this.#takeHelm() },
      'Take the helm',
    );
    this.plot = el('canvas', {
      className: 'timeline-plot',
      role: 'img',
      'aria-label': 'Events over time',
    });
    this.plot.addEventListener('click', ({ offsetX }) => this.seek(this.#timeAt(offsetX)));
    this.element = byId('timeline');
    this.element.setAttribute('aria-label', 'Time line');
    this.element.append(
      el('div', { className: 'group' }, this.play, this.time),
      this.slider,
      el('div', { className: 'group' }, this.events, this.helm),
      this.plot,
    );
    station.addEventListener('state', () => this.#follow(station.state.time));
    telemetry.addEventListener('change', () => this.#follow(telemetry.stamp_s));
    new ResizeObserver(() => this.#draw()).observe(this.plot);
  }

  get isShown() {
    return this.#replay !== null;
  }

  /** Show the time line of a session, if it is a replay.
   * @param {import('../wire/messages.js').Description} description
   */
  begin({ replay = null, branched_from: branchedFrom = '' }) {
    this.#replay = replay;
    this.element.hidden = !replay;
    byId('station').classList.toggle('is-replay', replay !== null);
    this.panel.efforts.element.closest('section').hidden = replay !== null;
    byId('scenario-name').title = branchedFrom ? `Flown on from ${branchedFrom}` : '';
    if (!replay) return;
    this.slider.min = String(Math.floor(replay.start_s)); // whole steps from 0
    this.slider.max = String(Math.ceil(replay.end_s));
    this.events.replaceChildren(
      option('', `${replay.events.length === 1 ? '1 event' : `${replay.events.length} events`}`),
      ...replay.events.map((event) => option(event.time_s, `${clockText(event.time_s, 1)} ${happened(event)}`)),
    );
    this.#follow(this.station.state.time);
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
    const { station } = this;
    if (!this.#replay) return;
    const { end_s } = this.#replay;
    const text = `${clockText(time_s, 1)} / ${clockText(end_s, 1)}`;
    write(this.time, text);
    write(this.play, station.state.paused ? 'Play' : 'Pause');
    if (!this.#isHeld) this.slider.value = String(time_s);
    this.slider.setAttribute('aria-valuetext', text);
    for (const each of [this.play, this.slider, this.events, this.helm]) each.disabled = !station.isPilot;
    this.#draw();
  }

  #draw() {
    const width = this.plot.clientWidth;
    if (!this.#replay || !width) return;
    const [from_s, to_s] = [Number(this.slider.min), Number(this.slider.max)];
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
    mark(this.#isSeeking ? Number(this.slider.value) : this.now_s, '--accent');
  }

  #timeAt(px) {
    const [from_s, to_s] = [Number(this.slider.min), Number(this.slider.max)];
    return from_s + ((px - INSET_PX) / (this.plot.clientWidth - 2 * INSET_PX)) * (to_s - from_s);
  }

  #playOrPause() {
    attempt(this.station.control(this.station.state.paused ? 'resume' : 'pause'));
  }

  #goToEvent() {
    if (this.events.value !== '') this.seek(Number(this.events.value));
    this.events.value = '';
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
