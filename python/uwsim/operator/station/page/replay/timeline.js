// The time line of a replay, in place of the controls that drive: time, events, another flight beside it, the helm.
import { attempt, byId, clockText, el, fixed, tip, toast, write } from '../dom.js';
import { happened } from '../said.js';
import { STRINGS } from '../strings.js';
import { begunText } from './flights.js';
import { Ghost } from './ghost.js';
import { drawPlot } from './plot.js';

const WORDS = STRINGS.replay;
const INSET_PX = 8; // half of the slider's thumb
const option = (value, text) => el('option', { value }, text);

export class Timeline {
  now_s = 0;
  /** @type {import('../wire/messages.js').ReplayDescription | null} */
  #replay = null; // as described by the server
  #wanted_s = NaN; // the time to go to next
  #isSeeking = false;
  #isHeld = false; // whether the user is holding the slider

  constructor(station, telemetry, { scene, chart, panel }) {
    this.station = station;
    this.panel = panel;
    this.ghost = new Ghost(station, scene, chart);
    this.play = el('button', { type: 'button', className: 'strong', onclick: () => this.#playOrPause() });
    this.time = el('output', { className: 'reading', 'aria-label': WORDS.time });
    this.slider = el('input', { type: 'range', 'aria-label': WORDS.slider, step: '0.05' });
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    this.slider.addEventListener('pointerdown', () => (this.#isHeld = true));
    this.slider.addEventListener('pointerup', () => (this.#isHeld = false));
    this.events = el('select', { 'aria-label': WORDS.events, onchange: () => this.#goToEvent() });
    this.helm = el('button', { type: 'button', className: 'primary', onclick: () => this.#takeHelm() }, WORDS.helm);
    this.overlay = el('select', { 'aria-label': WORDS.overlay, onchange: () => this.#choose() });
    this.plot = el('canvas', { className: 'timeline-plot', role: 'img', 'aria-label': WORDS.plot });
    this.plot.addEventListener('click', ({ offsetX }) => this.seek(this.#timeAt(offsetX)));
    this.apart = el('output', { className: 'timeline-apart', 'aria-label': WORDS.apartLabel });
    this.element = byId('timeline');
    this.element.setAttribute('aria-label', WORDS.title);
    this.element.append(
      el('div', { className: 'group' }, this.play, this.time),
      this.slider,
      el('div', { className: 'group' }, this.events, this.helm),
      this.overlay,
      this.plot,
      this.apart,
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
  begin({ replay = null, branched_from: branchedFrom = '', scenario }) {
    this.#replay = replay;
    this.element.hidden = !replay;
    byId('station').classList.toggle('is-replay', replay !== null);
    this.panel.efforts.element.closest('section').hidden = replay !== null;
    tip(byId('scenario-name'), branchedFrom ? WORDS.branched(branchedFrom) : '');
    this.ghost.show('');
    if (!replay) return;
    this.slider.min = String(Math.floor(replay.start_s)); // whole steps from 0
    this.slider.max = String(Math.ceil(replay.end_s));
    this.events.replaceChildren(
      option('', WORDS.eventCount(replay.events.length)),
      ...replay.events.map((event) => option(event.time_s, `${clockText(event.time_s, 1)} ${happened(event)}`)),
    );
    this.#offer(replay.flight, scenario);
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
    const text = WORDS.at(clockText(time_s, 1), clockText(end_s, 1));
    write(this.time, text);
    write(this.play, station.state.paused ? WORDS.play : WORDS.pause);
    if (!this.#isHeld) this.slider.value = String(time_s);
    this.slider.setAttribute('aria-valuetext', text);
    for (const each of [this.play, this.slider, this.events, this.helm]) each.disabled = !station.isPilot;
    this.ghost.moveTo(time_s);
    const apart = this.ghost.apart(time_s);
    const most = this.ghost.found?.apart_m.reduce((a, b) => Math.max(a, b), 0) ?? 0;
    write(
      this.apart,
      !this.ghost.found ? '' : Number.isFinite(apart) ? WORDS.apart(fixed(apart, 2), fixed(most, 2)) : WORDS.over,
    );
    this.#draw();
  }

  #draw() {
    if (!this.#replay) return;
    const { events } = this.#replay;
    const [from_s, to_s] = [Number(this.slider.min), Number(this.slider.max)];
    const now_s = this.#isSeeking ? Number(this.slider.value) : this.now_s;
    drawPlot(this.plot, { from_s, to_s, now_s, inset: INSET_PX, events, ghost: this.ghost.found });
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
    attempt(this.station.control('helm'), WORDS.taken);
  }

  // Offer the other flights in the same scenario.
  async #offer(own, scenario) {
    this.overlay.replaceChildren(option('', WORDS.alone));
    try {
      const { flights = [] } = await this.station.catalog();
      const others = flights.filter((each) => each.name !== own && each.scenario === scenario && !each.refused);
      this.overlay.append(
        ...others.map(({ name, begun, duration_s }) =>
          option(name, WORDS.with(begunText(begun) || name, clockText(duration_s))),
        ),
      );
    } catch (error) {
      toast(error.message, 'error');
    }
  }

  async #choose() {
    write(this.apart, this.overlay.value ? WORDS.reading : '');
    try {
      await this.ghost.show(this.overlay.value);
    } catch (error) {
      this.overlay.value = '';
      toast(error.message, 'error');
    }
    this.#show(this.now_s);
  }
}
