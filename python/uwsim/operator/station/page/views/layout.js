// The views: one large, the others small, swapped by click or number key. Each camera or sonar is a stream of pictures.
import { el, write } from '../dom.js';
import { covered, isHandheld, isNarrow } from '../handheld.js';
import { cameraAxis, focalPixels } from './camera_axis.js';
import { Hud } from './hud.js';
import { numberKeys } from './number_keys.js';
import { Previews } from './previews.js';
import { Picture } from './picture.js';
import { SonarScreen } from './sonar_screen.js';
import { folded, isFilled, strip, unfolded } from './strip.js';
import { SONAR_KINDS } from '../wire/messages.js';

const LATE_MS = 2500; // of the large view; small ones take turns
const SMALL_LATE_MS = 20000;
const KINDS = ['camera', 'chase', 'scene', 'chart', 'fan', ...SONAR_KINDS, 'station'];
const HELD = {
  // the small views of a hand-held screen, while its bar is folded
  tablet: { kinds: ['chart', 'fan', 'forward_looking', 'camera'], most: 3 },
  phone: { kinds: ['chart', 'camera'], most: 1 },
};
const AHEAD = /front/; // cameras that look ahead, where the server does not describe them
const CAMERAS = new Set(['camera', 'station', 'chase']);
const REDUCED = 0.95; // share of its width below which a picture is reduced
const LARGE = { credit: 2 };
const LATE_PERIODS = 3; // in periods of the pictures that arrive over a link
const OVER_REM = { held: 4, else: 1.5 }; // margin below which the line about the link lies
const SELDOM_S = 0.5; // longer intervals between pictures are displayed

// A view of a vehicle's camera whose pictures come over a link has `link`: { modem, period_s, large_only }. period_s is
// null if there is no capacity for pictures. large_only: only pictures of the large view are carried.
function linkText({ modem, period_s: period }) {
  if (period === null) return `${modem} has no capacity for pictures`;
  if (period < SELDOM_S) return `over ${modem}`;
  return `over ${modem}: 1 picture in ${period < 10 ? +period.toFixed(1) : Math.round(period)} s`;
}

const rank = ({ kind }) => (KINDS.includes(kind) ? KINDS.indexOf(kind) : KINDS.length);

export class Views extends EventTarget {
  #views = new Map(); // name: { view, element, picture, hud, scene, lost }
  #large = new URLSearchParams(location.search).get('view') ?? ''; // as uwsim.view asks for the scene
  #isFilled = false; // the large picture has no bars
  #isUnfolded = false; // on a hand-held screen: all views are shown, to choose one
  #isAboard = false; // whether views show the vehicle's own pictures, not those carried by the link
  #cameras = new Previews();
  #sonars = new Previews();
  armShown = () => /** @type {{ short: string, text: string }[]} */ ([]); // see ArmDrive
  #keys = /** @type {Map<string, number>} */ (new Map()); // see numberKeys
  widths = new Map(); // of large pictures, as last requested; 0 or none: their camera's
  #tools = el('div', { className: 'picture-tools' });

  // drawn: the views that this page draws itself, each { name, title, kind, element, setLarge(isLarge) }.
  constructor(station, telemetry, container, drawn) {
    super();
    this.station = station;
    this.telemetry = telemetry;
    this.container = container;
    this.drawn = drawn;
    telemetry.addEventListener('change', () => this.#drawHud());
    document.addEventListener('visibilitychange', () => this.#choosePictures());
    addEventListener('screen', () => this.enlarge(this.#large));
    new ResizeObserver(() => {
      this.#fit();
      this.#drawHud();
    }).observe(container);
    setInterval(() => this.#look(), 500);
  }

  // Controls of the large camera's picture, shown over it.
  setTools(...tools) {
    this.#tools.append(...tools);
  }

  get large() {
    return this.#large;
  }

  get largeView() {
    return this.#views.get(this.#large);
  }

  get names() {
    return [...this.#views.keys()];
  }

  picture(name) {
    return this.#views.get(name)?.picture;
  }

  sonarOf(name) {
    return this.#views.get(name)?.sonar ?? null;
  }

  hudOf(name) {
    return this.#views.get(name)?.hud ?? null;
  }

  // Show these views (of describe.views) and those that this page draws, in the order of their kinds.
  fill(views) {
    for (const { picture } of this.#views.values()) picture?.show('');
    const all = [...views, ...this.drawn].toSorted((a, b) => rank(a) - rank(b));
    this.#keys = numberKeys(all);
    const frame = (view) => (view.element ? this.#frame(view, ...view.element) : this.#pictureView(view));
    this.#views = new Map(all.map((view) => [view.name, frame(view)]));
    this.container.replaceChildren(...[...this.#views.values()].map(({ element }) => element));
    const shown = all.find(({ link }) => link?.period_s !== null) ?? all[0];
    this.enlarge(this.#views.has(this.#large) ? this.#large : shown.name);
  }

  // Show all views as small ones on a hand-held screen, or those of HELD; see the button that unfolds the bar.
  setUnfolded(isUnfolded) {
    this.#isUnfolded = isUnfolded;
    this.enlarge(this.#large);
  }

  enlarge(name) {
    if (!this.#views.has(name)) return;
    this.#large = name;
    for (const [other, { element }] of this.#views) element.classList.toggle('is-large', other === name);
    this.#fit();
    for (const own of this.drawn) own.setLarge(name === own.name);
    for (const [other, { sonar }] of this.#views) sonar?.setLarge(other === name);
    if (this.largeView.isCamera) this.largeView.element.append(this.#tools);
    else this.#tools.remove();
    this.#choosePictures();
    this.#drawHud();
    this.dispatchEvent(new Event('swap'));
  }

  // Show the vehicle's own pictures, where the server permits it, or those carried by the modem.
  setAboard(isAboard) {
    this.#isAboard = isAboard;
    this.#choosePictures();
    this.#look();
  }

  // The name of the large view's camera, on the vehicle with a prefix, or ''.
  ownCamera(prefix = '') {
    const view = this.largeView?.view;
    return view?.kind === 'camera' && view.optics?.follows === 'body' ? view.name.slice(prefix.length) : '';
  }

  enlargeNumber(number) {
    this.enlarge([...this.#keys].find(([, key]) => key === number)?.[0] ?? '');
  }

  // The titles of the views that have number keys, by key.
  get keyed() {
    return [...this.#keys].map(([name, key]) => ({ key: String(key), title: this.#views.get(name)?.title ?? name }));
  }

  // The names of the small views.
  #small(isFolded) {
    const found = [...this.#views.values()].map(({ view }) => view).filter(({ name }) => name !== this.#large);
    const { kinds, most } = HELD[isNarrow() ? 'phone' : 'tablet'];
    const chosen = kinds.flatMap((each) => found.filter(({ kind }) => kind === each)).slice(0, most);
    return (isFolded ? chosen : found).map(({ name }) => name);
  }

  #fit() {
    const { clientWidth, clientHeight, style, parentElement } = this.container;
    const isFolded = isHandheld() && !this.#isUnfolded;
    const small = this.#small(isFolded);
    const divided = isFolded ? folded : isHandheld() ? unfolded : strip;
    const { columns, rows, row_px } = divided(clientWidth, clientHeight, small.length);
    let isChanged = false;
    for (const [name, { element }] of this.#views) {
      const isHidden = name !== this.#large && !(rows > 0 && small.includes(name));
      isChanged ||= element.hidden !== isHidden;
      element.hidden = isHidden;
    }
    if (isChanged) this.#choosePictures();
    this.#isFilled = isHandheld() || isFilled(clientWidth, clientHeight - rows * row_px);
    this.container.classList.toggle('is-filled', this.#isFilled);
    style.setProperty('--columns', String(columns));
    style.setProperty('--row', `${row_px}px`);
    parentElement?.style.setProperty('--strip', `${rows * row_px}px`);
  }

  #frame(view, ...contents) {
    const { name, title } = view;
    const key = String(this.#keys.get(name) ?? '');
    const [lost, over] = [el('span', {}, 'No picture'), el('p', { className: 'over', hidden: true })];
    const element = el(
      'section',
      { className: 'view', 'aria-label': title, 'data-view': name },
      ...contents,
      el('p', { className: 'lost' }, lost),
      over,
      el('p', { className: 'name' }, el('b', { hidden: key === '' }, key), title),
      el('button', {
        type: 'button',
        className: 'swap',
        'aria-label': `Make ${title} the large view (key ${key})`,
        onclick: () => this.enlarge(name),
      }),
    );
    return { view, title, element, lost, over };
  }

  #pictureView(view) {
    const sonar = view.sonar ? new SonarScreen(view.sonar) : null;
    const canvas = sonar?.canvas ?? el('canvas', { className: 'picture', width: 16, height: 9 });
    Object.assign(canvas, { role: 'img', ariaLabel: `Picture: ${view.title}` });
    const isCamera = CAMERAS.has(view.kind);
    const hasHud = view.kind === 'camera' && (view.optics ? view.optics.follows === 'body' : AHEAD.test(view.name));
    const hudCanvas = hasHud ? el('canvas', { className: 'hud', 'aria-hidden': 'true' }) : null;
    const frame = this.#frame(view, ...(sonar?.element ?? [canvas, hudCanvas]));
    const picture = new Picture(this.station.bridge, sonar?.source ?? canvas);
    picture.addEventListener('drawn', () => {
      frame.element.classList.remove('is-stale');
      sonar?.show();
    });
    return { ...frame, picture, isCamera, sonar, hud: hasHud ? new Hud(hudCanvas) : null };
  }

  // Request no pictures for a hidden tab, so that none are rendered.
  #choosePictures() {
    const cameras = [];
    const sonars = [];
    /** @type {{ picture: any, topic: string } | null} */
    let large = null;
    for (const [name, { view, picture, isCamera, element }] of this.#views) {
      if (!picture || document.hidden || element.hidden) picture?.show('');
      else if (name === this.#large) large = { picture, topic: this.#isFull(view) ? view.aboard_topic : view.topic };
      else if (view.link?.large_only && !isCamera)
        picture.show(''); // it would take the modem's time
      else (isCamera ? cameras : sonars).push({ picture, topic: this.#smallTopic(view) });
    }
    this.#cameras.show(cameras);
    this.#sonars.show(sonars); // sonar pictures come at their own pace
    large?.picture.show(large.topic, LARGE); // last, after the preview of the same topic has ended
  }

  // link: the entry `link` of a view whose pictures arrive over a link.
  #whyNone(name, link) {
    if (link && link.period_s === null) return 'No picture';
    return link?.large_only && name !== this.#large ? 'Enlarge to request it' : 'Waiting for a picture';
  }

  // Test if pictures are narrower than requested, because the server would otherwise not keep their rate.
  #isReduced({ name, width = 0 }, { topic, canvas, drawn }) {
    const wanted = this.widths.get(name) || width;
    return topic !== '' && drawn > 0 && canvas.width < REDUCED * Math.min(wanted, width);
  }

  #isFull(view) {
    return this.#isAboard && Boolean(view.aboard_topic);
  }

  #smallTopic(view) {
    return (this.#isFull(view) ? view.aboard_small_topic : view.small_topic) || view.topic;
  }

  #drawHud() {
    for (const [name, { hud, view, picture, over }] of this.#views) {
      if (!hud) continue;
      if (name !== this.#large) {
        hud.clear();
        continue;
      }
      const margins = covered(this.station.isPilot, this.#isUnfolded);
      if (!over.hidden) margins.foot = Math.max(margins.foot, isHandheld() ? OVER_REM.held : OVER_REM.else);
      hud.draw(this.telemetry.message, {
        isStale: this.telemetry.isStale,
        axis: this.#axis(view),
        focal: view.optics ? focalPixels(1, view.optics) : NaN,
        contact: this.telemetry.contact,
        aspect: picture.canvas.width / picture.canvas.height,
        arm: this.armShown(),
        isFilled: this.#isFilled,
        covered: margins,
        proximity_m: this.station.description?.warnings?.proximity_m ?? 0,
      });
    }
  }

  // The direction of a camera's axis from the reported motor angles; null if these are unknown.
  #axis({ name, optics }) {
    const { message, joints } = this.telemetry;
    if (!message || !optics) return null;
    const [pan_rad, tilt_rad] = [joints.get(`${name}_pan`), joints.get(`${name}_tilt`)];
    if (optics.turns && pan_rad === undefined) return null;
    return cameraAxis(message.orientation, optics, { pan_rad, tilt_rad });
  }

  #look() {
    const { isBlind, state } = this.station;
    for (const [name, { element, view, picture, lost, over }] of this.#views) {
      if (!picture) continue;
      const isLinked = Boolean(view.link) && !this.#isFull(view);
      const isReduced = !isLinked && name === this.#large && this.#isReduced(view, picture);
      over.hidden = (!isLinked && !isReduced) || name !== this.#large;
      if (isLinked) write(over, linkText(view.link));
      else if (isReduced) write(over, 'Picture reduced: the machine is busy');
      const periodMs = isLinked ? LATE_PERIODS * 1000 * (view.link.period_s ?? 0) : 0;
      const lateMs = Math.max(name === this.#large ? LATE_MS : SMALL_LATE_MS, periodMs);
      const isLate = isBlind || (!state.paused && performance.now() - picture.arrivedMs > lateMs);
      element.classList.toggle('is-stale', isLate || picture.drawn === 0);
      write(lost, picture.drawn > 0 ? 'Old picture' : this.#whyNone(name, isLinked && view.link));
    }
    if (this.telemetry.isStale) this.#drawHud();
  }
}
