// The entry point: connects, shows the start screen or the station, and connects the parts.
import './theme.js';
import './handheld.js';
import { CameraAim } from './camera_aim.js';
import { watchDialogs } from './dialogs/dialog.js';
import { showGamepads } from './dialogs/gamepad.js';
import { showKeys } from './dialogs/keys.js';
import { showMenu } from './dialogs/menu.js';
import { byId, targetOf, toast, write } from './dom.js';
import { SceneEditor } from './editor/editor.js';
import { ArmDrive } from './drive/arm_drive.js';
import { Bindings, keyName } from './drive/bindings.js';
import { explainIdleKeys } from './drive/hint.js';
import { HoldButtons } from './drive/holds.js';
import { Inspector } from './inspector.js';
import { Lease } from './drive/lease.js';
import { Pilot } from './drive/pilot.js';
import { Inspection } from './panel/inspection.js';
import { partName } from './panel/arm.js';
import { Panel } from './panel/panel.js';
import { Recorder } from './recorder.js';
import { Exercises } from './exercises.js';
import { Flights } from './replay/flights.js';
import { Timeline } from './replay/timeline.js';
import { Life } from './map3d/life.js';
import { LooseObjects } from './map3d/loose_objects.js';
import { SceneView } from './map3d/scene.js';
import { Tethers } from './map3d/tethers.js';
import { StartScreen } from './start.js';
import { offerTasks } from './tasks.js';
import { OFTEN, subscribed, Telemetry } from './telemetry.js';
import { TopBar } from './topbar.js';
import { ChartView } from './views/chart.js';
import { FanView } from './views/fan.js';
import { Views } from './views/layout.js';
import { TYPES } from './wire/messages.js';
import { keptName } from './wire/name.js';
import { bridgeUrl, Station } from './wire/station.js';

const MAP = { throttle_rate: 250, queue_length: 1 };
const SCAN = { throttle_rate: 200 };

const station = new Station(bridgeUrl(location), keptName());
const telemetry = new Telemetry(station);
const bindings = new Bindings();
const scene = new SceneView();
const fan = new FanView();
const chart = new ChartView(station);
const views = new Views(station, telemetry, byId('views'), [fan, scene, chart]);
const arm = new ArmDrive(station, () => views.ownCamera(vehicle?.prefix));
views.armShown = () => arm.shown(telemetry, partName);
const pilot = new Pilot(station, bindings, arm, act);
byId('station').append(pilot.touch.element);
const aim = new CameraAim(station, views);
views.setTools(aim.element);
const holds = new HoldButtons(station, telemetry, pilot, (action) => bindings.keysOf(action).map(keyName)[0]);
const recorder = new Recorder(station, telemetry, views);
const lease = new Lease(station);
const topbar = new TopBar(
  station,
  telemetry,
  pilot,
  views,
  { holds, recorder, lease },
  {
    stop: () => panel.allStop.press(),
    fly: flyOther,
    unfold,
    keys: openKeys,
    menu: openMenu,
  },
);
const inspection = new Inspection(station, views);
const panel = new Panel(byId('panel'), station, telemetry, pilot, inspection);
panel.link.onAboard = (isAboard) => views.setAboard(isAboard);
inspection.addEventListener('notes', () => showNotes());
explainIdleKeys(station, telemetry, pilot, bindings);
const inspector = new Inspector(station);
const objects = new LooseObjects(scene, chart);
const life = new Life(scene, chart);
const tethers = new Tethers(scene, chart);
const timeline = new Timeline(station, telemetry);
const flights = new Flights(station);
const editor = new SceneEditor(station);
const exercises = new Exercises(station);
const start = new StartScreen(
  station,
  (catalog) => {
    flights.show(catalog.flights);
    exercises.show(catalog.exercises);
  },
  editor,
);
offerTasks((task) => start.showTask(task));
let ends = []; // ends of this session's subscriptions
let vehicle = null;

watchDialogs((isOpen) => {
  pilot.suspend(isOpen);
  aim.stop();
});
addEventListener('blur', () => aim.stop());
addEventListener('keydown', (event) => {
  if (
    targetOf(event).matches('input, select, textarea') ||
    event.ctrlKey ||
    event.metaKey ||
    event.altKey ||
    !station.isRunning
  )
    return;
  const isOpen = document.querySelector('dialog[open]');
  if (event.key === '?' && !isOpen) openKeys();
  else if (event.key === 'Escape' && !isOpen) openMenu();
  else if (event.key === 'Enter' && !isOpen && station.awaitsBegin && event.target === document.body)
    panel.exercise.beginAttempt();
  else if (/^Digit\d$/.test(event.code) && !event.shiftKey && !isOpen) views.enlargeNumber(Number(event.code.slice(5)));
  else return;
  event.preventDefault();
});

station.addEventListener('state', () => {
  const description = station.isRunning ? station.description : null;
  const isRunning = description !== null;
  byId('station').hidden = !isRunning;
  byId('station').classList.toggle('is-pilot', station.isPilot);
  byId('start').hidden = isRunning || station.state.phase === '';
  if (station.state.phase === 'idle') start.show();
  document.title = description ? `${description.scenario} – uwsim station` : 'uwsim station';
  if (isRunning) lease.takeOnce();
  showBanner();
});
station.addEventListener('close', showBanner);
station.addEventListener('open', showBanner);
setInterval(() => station.isBlind && showBanner(), 500);
station.addEventListener('trouble', (event) => toast(/** @type {CustomEvent} */ (event).detail, 'error'));
station.addEventListener('session', begin);
station.addEventListener('description', describe);

function flyOther(name) {
  pilot.release();
  vehicle = station.description?.vehicles.find((each) => each.name === name);
  begin();
}

// On a hand-held screen, show all controls, or few.
function unfold() {
  const isUnfolded = byId('station').classList.toggle('is-unfolded');
  byId('unfold').setAttribute('aria-expanded', String(isUnfolded));
  views.setUnfolded(isUnfolded);
}

// Show the vehicle that the controls act on.
function describe() {
  const description = /** @type {import('./wire/messages.js').Description} */ (station.description);
  vehicle = description.vehicles.find(({ name }) => name === vehicle?.name) ?? description.vehicles[0];
  topbar.begin(vehicle);
  panel.begin(vehicle, description);
  holds.begin(vehicle);
  inspection.begin(vehicle);
}

// Show another simulator, or the same one from its start.
function begin() {
  const description = /** @type {import('./wire/messages.js').Description} */ (station.description);
  for (const end of ends) end();
  describe();
  pilot.vehicle = vehicle.name;
  arm.begin(vehicle);
  telemetry.watch(vehicle);
  aim.begin(vehicle);
  fan.clear();
  views.fill(
    description.views.filter((view) => view.kind !== 'fan' && (!view.vehicle || view.vehicle === vehicle.name)),
  );
  scene
    .begin(load, description.vehicles, description.scene)
    .then(showNotes)
    .catch((error) => toast(`The 3D view is empty: ${error.message}`, 'error'));
  chart.begin(load, vehicle.name, description.scene).catch((error) => toast(error.message, 'error'));
  chart.lanes.hidden = !description.has_survey;
  if (start.takesSurvey()) {
    views.enlarge('chart');
    chart.layLanes();
  }
  objects.begin(load, description).catch((error) => toast(error.message, 'error'));
  ends = description.vehicles.flatMap((each) => watch(each));
  ends.push(...tethers.begin(station.bridge, description, SCAN));
  ends.push(...life.begin(station.bridge, description, SCAN));
  ends.push(...listen(description.objects, 'tf2_msgs/TFMessage', (message) => objects.show(message), SCAN));
  panel.showMap(scene.store);
  timeline.begin(description);
}

function showMap(changes) {
  scene.showMap(changes);
  panel.showMap(scene.store);
}

function watch({ name, telemetry: topic, map_changes: map, scan }) {
  const isFlown = name === vehicle.name;
  let tilt_rad = 0;
  const showTelemetry = (message) => {
    tilt_rad = Number.isFinite(message.tilt) ? message.tilt : 0;
    scene.showTelemetry(name, message);
    if (isFlown) chart.showTelemetry(message);
  };
  const showScan = (message) => {
    scene.showScan(name, message, tilt_rad);
    if (isFlown) fan.show(message);
  };
  return [
    ...listen(topic, TYPES.Telemetry, showTelemetry, OFTEN),
    ...listen(scan, 'sensor_msgs/LaserScan', showScan, SCAN),
    ...listen(isFlown && map, TYPES.MapChanges, showMap, MAP),
  ];
}

const listen = subscribed.bind(null, station.bridge);
const load = (path) => station.load(path);

function act(action, isPressed) {
  if (aim.act(action, isPressed)) return;
  if (action === 'tiltUp' || action === 'tiltDown') {
    topbar.tilt(action === 'tiltUp' ? 1 : -1, isPressed);
    return;
  }
  if (action === 'gripClose' || action === 'gripOpen') arm.grip(action === 'gripClose' ? 1 : -1, isPressed);
  if (!isPressed) return;
  if (action.startsWith('hold.')) holds.press(action.slice(5));
  const actions = {
    stop: () => panel.allStop.press(),
    zero: () => pilot.stop(),
    release: () => topbar.releaseOrDock(),
    undock: () => topbar.undock(),
    drop: () => topbar.drop(),
    frontOn: () => topbar.light('front', true),
    frontOff: () => topbar.light('front', false),
    downOn: () => topbar.light('down', true),
    downOff: () => topbar.light('down', false),
    front: () => topbar.switchLight('front'),
    down: () => topbar.switchLight('down'),
    armNext: () => arm.next(1),
    armBefore: () => arm.next(-1),
    gainUp: () => pilot.changeGain(1),
    gainDown: () => pilot.changeGain(-1),
    note: () => inspection.add(),
    comment: () => inspection.focus(),
    pause: () => topbar.pauseOrResume(),
    step: () => topbar.step(),
    snapshot: () => recorder.snapshot(),
    record: () => recorder.toggle(),
    mute: () => panel.alarms.setSound(!panel.alarms.isLoud),
  };
  actions[action]?.();
}

// Notes are shown at their positions in the 3D view and on the chart.
function showNotes() {
  const placed = inspection.notes.filter(({ position_m }) => position_m);
  scene.showNotes(placed);
  chart.showNotes(placed);
}

function openKeys() {
  showKeys(bindings, views.keyed);
}

function openMenu() {
  showMenu(station, { keys: openKeys, gamepad: () => showGamepads(pilot.gamepads), edit: () => editor.open('') });
}

function showBanner() {
  const { connected, state, isSilent, isBlind } = station;
  const seconds = Number.isFinite(station.silence_s) ? ` for ${Math.floor(station.silence_s)} s` : '';
  byId('station').classList.toggle('is-blind', isBlind);
  const text = !connected
    ? `Not connected to ${new URL(station.bridge.url, location.href).host}${seconds}; trying again. The vehicle stops by itself.`
    : isSilent
      ? `Nothing has arrived${seconds}: the display is out of date.${station.flew ? ' Your keys do nothing.' : ''} The vehicle stops by itself.`
      : state.error
        ? `The simulation stopped: ${state.error}`
        : station.pilotSilence > 0
          ? `${station.nameOf(state.pilot)} has been silent for ${Math.round(station.pilotSilence)} s: efforts are zero.`
          : state.rosbridge_trouble
            ? `Not connected to your rosbridge at ${state.rosbridge}: ${state.rosbridge_trouble}; trying again.`
            : '';
  write(byId('banner'), text);
  byId('banner').hidden = text === '';
  byId('banner').dataset.kind = isBlind || state.error ? '' : 'silence';
}

globalThis.station = {
  arm,
  chart,
  station,
  telemetry,
  pilot,
  views,
  scene,
  panel,
  bindings,
  recorder,
  inspector,
  inspection,
  timeline,
  editor,
  objects,
  life,
  tethers,
}; // for the browser's console and tests
