// The page's logic that needs neither a document nor a server. node page.mjs
import assert from 'node:assert/strict';

import { clockText } from '../../python/uwsim/operator/station/page/dom.js';
import { PRESETS } from '../../python/uwsim/operator/station/page/drive/bindings.js';
import { shownHolds, switched } from '../../python/uwsim/operator/station/page/drive/holds.js';
import {
  Arming,
  Calibration,
  defaultProfile,
  Profiles,
  readPad,
  shaped,
} from '../../python/uwsim/operator/station/page/drive/pads.js';
import { crosses } from '../../python/uwsim/operator/station/page/map3d/sight.js';
import { AlarmLog } from '../../python/uwsim/operator/station/page/panel/alarm_log.js';
import { inUnit } from '../../python/uwsim/operator/station/page/units.js';
import {
  axisText,
  cameraAxis,
  focalPixels,
  pixelsBelow,
} from '../../python/uwsim/operator/station/page/views/camera_axis.js';
import {
  ChartFrame,
  heightAt,
  measured,
  pathLength,
} from '../../python/uwsim/operator/station/page/views/chart_frame.js';
import { contours } from '../../python/uwsim/operator/station/page/views/chart_ground.js';
import { together, wayTo } from '../../python/uwsim/operator/station/page/views/chart_marks.js';
import { Telemetry } from '../../python/uwsim/operator/station/page/telemetry.js';
import { Closing, soonest } from '../../python/uwsim/operator/station/page/views/closing.js';
import {
  Fan,
  reaches,
  recolouring,
  ringStep,
  Waterfall,
} from '../../python/uwsim/operator/station/page/views/sonar_geometry.js';
import { Previews } from '../../python/uwsim/operator/station/page/views/previews.js';
import { strip } from '../../python/uwsim/operator/station/page/views/strip.js';

const near = (got, expected, tolerance) => assert.ok(Math.abs(got - expected) <= tolerance, `${got}: not ${expected}`);
const RAD = Math.PI / 180;

// Seconds are rounded before they are minutes.
assert.equal([119.6, 3599.96, 59.94].map((time) => clockText(time)).join(), '2:00,1:00:00,1:00');
assert.equal([119.96, 59.94, 7].map((time) => clockText(time, 1)).join(), '2:00.0,0:59.9,0:07.0');

// No key of a set of keys does two things.
for (const { keys } of Object.values(PRESETS)) {
  const codes = Object.values(keys).flat();
  assert.deepEqual(codes, [...new Set(codes)]);
}

// Holds: one press switches one, and replaces the one that sets the same axes.
const on = (active, name) => Object.entries(switched(active, name)).flatMap(([each, is]) => (is ? [each] : []));
assert.deepEqual(on([], 'depth'), ['depth']);
assert.deepEqual(on(['heading', 'depth'], 'altitude'), ['heading', 'altitude']);
assert.deepEqual(on(['position', 'heading'], 'speed'), ['heading', 'speed']);
assert.deepEqual(on(['heading', 'depth'], 'heading'), ['depth']);

// The display has the compass heading of a yaw, and no target while the vehicle comes to rest.
const shown = (holds, hold_targets) => shownHolds({ holds, hold_targets }).map(({ short, text }) => `${short} ${text}`);
assert.deepEqual(shown(['heading'], [0]), ['HDG 090°']);
assert.deepEqual(shown(['heading'], [-Math.PI]), ['HDG 270°']);
assert.deepEqual(shown(['depth', 'position'], [2.04, NaN]), ['DEP 2.0 m', 'POS –']);
assert.deepEqual(shownHolds({}), []);

// The horizon follows mount, motor and hull: their pitches add up, and a camera that looks back sees them reversed.
const LEVEL = [0, 0, 0, 1];
const noseDown = (degrees) => [0, Math.sin(0.5 * degrees * RAD), 0, Math.cos(0.5 * degrees * RAD)];
const mounted = (yaw, pitch) => ({ yaw_pitch_roll_deg: [yaw, pitch, 0], horizontal_fov_deg: 90 });
near(cameraAxis(LEVEL, mounted(0, 8)).up_deg, -8, 1e-9);
near(cameraAxis(noseDown(10), mounted(0, 8), { tilt_rad: 20 * RAD }).up_deg, -38, 1e-9);
near(cameraAxis(noseDown(10), mounted(180, 0)).up_deg, 10, 1e-9);
near(cameraAxis(noseDown(10), mounted(90, 0)).roll_deg, 10, 1e-9); // a camera to port: its picture rolls
assert.equal(
  axisText(cameraAxis(LEVEL, mounted(0, 0), { pan_rad: -30 * RAD, tilt_rad: 5 * RAD })),
  '30° starboard, 5° down',
);
assert.equal(axisText(cameraAxis(noseDown(30), mounted(0, 90))), '90° down'); // relative to the vehicle
assert.equal(axisText(cameraAxis(noseDown(30), mounted(0, 0))), 'ahead');
near(focalPixels(640, mounted(0, 0)), 320, 1e-9);
near(pixelsBelow(-45, 0, 320), 320, 1e-9); // 45 degrees below the axis is at the edge of a square picture of 90 degrees
assert.equal(pixelsBelow(90, 0, 320), null);

// The time to contact at a constant speed is range over speed; receding, at rest or without an echo there is none.
const approached = (range_of, closing = new Closing()) => {
  for (let k = 0; k <= 40; k += 1) closing.add(range_of(0.1 * k), 0.1 * k);
  return closing;
};
near(approached((t) => 5 - 0.8 * t).time_s, (5 - 3.2) / 0.8, 0.05);
for (const none of [(t) => 5 + t, () => 5, () => NaN, () => Infinity]) assert.equal(approached(none).time_s, Infinity);
const again = approached((t) => 5 - t);
assert.equal(again.add(3, 0), Infinity); // after a restart
const around = new Map([
  ['bed', approached((t) => 5 - t)],
  ['fore', approached((t) => 4.4 - t)],
  ['port', approached((t) => 50 - t)],
]);
assert.equal(soonest(around).name, 'fore');
assert.equal(soonest(new Map([['port', around.get('port')]])), null);

// The bed below is no obstacle around the vehicle, and a proximity sensor that has failed does not keep a warning.
const heard = new Map();
const watched = new Telemetry({
  bridge: { subscribe: (topic, _, take) => heard.set(topic, take) },
  state: { factor: 1 },
});
watched.watch({ name: 'rov', telemetry: '/telemetry', proximities: [{ name: 'fore', topic: '/fore' }] });
const passes = (sec, range) => {
  const header = { stamp: { sec, nanosec: 0 } };
  heard.get('/telemetry')({ header, distance_to_seabed: 0.5 });
  if (range) heard.get('/fore')({ header, range, max_range: 10 });
};
passes(0);
assert.ok(Number.isNaN(watched.nearest_m));
for (const sec of [0, 1, 2]) passes(sec, 5 - sec);
assert.equal(watched.nearest_m, 3);
assert.equal(watched.contact.name, 'fore');
passes(5);
assert.ok(Number.isNaN(watched.nearest_m));
assert.equal(watched.contact, null);

// A collision stays until it is acknowledged; each alarm is logged once, when it begins; another run begins empty.
const log = new AlarmLog();
const quiet = { collisions: 2, alarms: [], hold_note: '' };
const take = (changes, time_s) => log.update({ ...quiet, ...changes }, time_s);
take({}, 1);
take({ collisions: 3, collision_warning: true, proximity_warning: true }, 2);
take({ collisions: 3, proximity_warning: true, alarms: ['water inside'] }, 3);
take({ collisions: 3, alarms: ['water inside'] }, 4);
assert.deepEqual(
  log.entries.map(({ time_s, text }) => `${time_s} ${text}`),
  ['3 water inside', '2 Near the bed', '2 Collision'],
);
assert.equal(log.collisions, 1);
log.acknowledge();
take({ collisions: 3, alarms: ['water inside'] }, 5);
assert.equal(log.collisions, 0);
take({ collisions: 0 }, 0.1);
assert.equal(log.entries.length, 0);

near(inUnit(1.8288, 'fathoms'), 1, 1e-12);
near(inUnit(1.8288, 'feet'), 6, 1e-12);

// Number keys. A key enlarges the same kind of view in every scenario; further views take the keys that are left.
const { numberKeys } = await import('../../python/uwsim/operator/station/page/views/number_keys.js');
const keysOf = (...kinds) => [...numberKeys(kinds.map((kind, k) => ({ kind, name: `${kind} ${k}` }))).values()];
assert.deepEqual(keysOf('camera', 'chase', 'scene', 'chart', 'fan', 'side_scan'), [1, 3, 4, 5, 6, 7]);
assert.deepEqual(keysOf('scene', 'chart', 'station'), [4, 5, 9]);
assert.deepEqual(new Set(keysOf('camera', 'camera', 'camera', 'scene')), new Set([1, 2, 3, 4]));
assert.equal(new Set(keysOf(...Array(12).fill('camera'))).size, 10);

// Gamepads. A pad of an unknown layout moves nothing, whatever its axes are at rest; one of the standard layout drives.
const pressed = (...values) => values.map((value) => ({ value, pressed: value > 0.5 }));
const odd = { id: 'odd', mapping: '', axes: [0.5, 0, -1, -1], buttons: pressed(1, 1) };
assert.deepEqual(readPad(odd, defaultProfile(odd)), { efforts: {}, actions: new Set() });
const usual = { id: 'usual', mapping: 'standard', axes: [0, 0, 0, -1], buttons: pressed(1) };
const read = readPad(usual, defaultProfile(usual));
assert.deepEqual(read.efforts, { yaw: 0, heave: 0, sway: 0, surge: 1 });
assert.deepEqual([...read.actions], ['stop']);

// Dead zone at rest, wherever that is; both ends reach full effort, and so does a trigger, which rests at one of them.
const stick = { rest: 0.1, low: -0.7, high: 0.9 };
assert.equal(shaped(0.15, stick), 0);
near(shaped(0.9, stick), 1, 1e-12);
near(shaped(-0.7, stick), -1, 1e-12);
const trigger = { rest: -1, low: -1, high: 1 };
assert.equal(shaped(-0.95, trigger), 0);
near(shaped(1, trigger), 1, 1e-12);
assert.equal(shaped(NaN), 0);
for (let value = -1; value < 1; value += 0.05) assert.ok(shaped(value + 0.05, stick) >= shaped(value, stick));

// Calibration learns rest and ends, and which axis was moved.
const learnt = new Calibration([0.1, -1, 0]);
for (const axes of [
  [0.1, -1, 0],
  [-0.7, -1, 0.01],
  [0.9, 1, 0],
])
  learnt.add(axes);
assert.deepEqual(learnt.ranges, { 0: stick, 1: trigger });
const pushed = new Calibration([0.1, -1, 0]);
pushed.add([-0.9, -1, 0]);
assert.deepEqual(pushed.moved, { axis: 0, sign: -1 });
assert.equal(new Calibration([0.5, 0, 0]).moved, null);

// Two triggers on one axis; the profile is kept by the pad's name.
const storage = { kept: null, getItem: () => storage.kept, setItem: (_, text) => (storage.kept = text) };
new Profiles(storage).keep(odd, { sticks: { heave: { plus: 1, minus: 0 } }, buttons: {}, ranges: {}, dead_zone: 0.1 });
const own = new Profiles(storage).of(odd);
near(readPad({ ...odd, buttons: pressed(0, 1) }, own).efforts.heave, 1, 1e-12);
near(readPad({ ...odd, buttons: pressed(1, 0) }, own).efforts.heave, -1, 1e-12);
assert.deepEqual(new Profiles(storage).of(usual), defaultProfile(usual));

// A pad drives only after its sticks have been at rest for some frames; again so after it was disarmed.
const arming = new Arming();
const pass = (surge, isAllowed = true) => arming.pass({ surge }, isAllowed).surge;
for (let k = 0; k < 20; k += 1) assert.equal(pass(0.7), 0);
for (let k = 0; k < Arming.LOOKS; k += 1) pass(0);
assert.equal(pass(0.7), 0.7);
assert.equal(pass(0.7, false), 0);
assert.equal(pass(0.7), 0);
const unknown = new Arming();
for (let k = 0; k < 20; k += 1) unknown.pass({}, true);
assert.equal(unknown.isArmed, false);

// A sonar's picture: what is drawn at a range and bearing is read there, in fans of any angle, up and down.
for (const half_deg of [20, 65, 120]) {
  for (const isDown of [false, true]) {
    const fan = new Fan({
      reach_m: 40,
      shown_m: 10,
      half_rad: half_deg * RAD,
      width: 800,
      height: 500,
      margin: 20,
      isDown,
    });
    const { range_m, bearing_rad } = fan.read(...fan.at(7, -0.3));
    near(range_m, 7, 1e-9);
    near(bearing_rad, -0.3, 1e-9);
    assert.equal(fan.read(...fan.at(11, 0)), null);
    for (const bearing of [-fan.half_rad, 0, fan.half_rad]) {
      const [x, y] = fan.at(10, bearing);
      assert.ok(x >= 19.9 && x <= 780.1 && y >= 19.9 && y <= 480.1, `${half_deg}: ${x}, ${y}`);
    }
    const [left, top, width, height] = fan.picture; // of 40 m, four times as large as what is shown
    near(left + width / 2, fan.apex[0], 1e-9);
    near(isDown ? top + height - fan.apex[1] : fan.apex[1] - top, 40 * fan.scale, 1e-6);
  }
}
const waterfall = new Waterfall({ reach_m: 50, shown_m: 25, width: 1000, height: 300 });
assert.deepEqual(waterfall.read(300, 10), { range_m: 10, bearing_rad: -Math.PI / 2 });
assert.deepEqual(waterfall.picture, [-500, 0, 2000, 300]);
assert.deepEqual(reaches(40), [2.5, 5, 10, 20, 40]);
assert.equal(ringStep(40), 10);
const coloured = (rgb, name, gain_db) => {
  const pixels = [...rgb, 255];
  recolouring(name, gain_db)(pixels);
  return pixels.slice(0, 3);
};
for (const rgb of [
  [0, 0, 0],
  [74, 37, 3],
  [196, 122, 26],
  [255, 251, 232],
]) {
  coloured(rgb, 'amber', 0).forEach((value, k) => near(value, rgb[k], 3)); // as received
}
near(coloured([196, 122, 26], 'grey', 0)[0], 128, 2);
near(coloured([196, 122, 26], 'grey', 12.5)[0], 255, 2); // half of the span above the middle

// The chart's frame: a place that is drawn somewhere is read there, and zooming keeps the place under the pointer.
const frame = new ChartFrame();
frame.size = [800, 400];
frame.fit([-10, -10, 10, 10]);
near(frame.scale, 20, 1e-9);
near(frame.place(frame.at([3, -4]))[1], -4, 1e-9);
assert.ok(frame.at([0, 5])[1] < frame.at([0, 0])[1]); // north is up
const under = frame.place([100, 50]);
frame.zoom(1.7, [100, 50]);
frame.place([100, 50]).forEach((value, k) => near(value, under[k], 1e-9));
near(measured([0, 0], [-3, -4]).length_m, 5, 1e-12);
near(measured([0, 0], [-1, 0]).bearing_deg, 270, 1e-9);
near(
  pathLength([
    [0, 0, 0],
    [3, 4, 0],
    [3, 4, -2],
  ]),
  7,
  1e-12,
);
const bed = { rows: 2, columns: 3, west_m: 0, south_m: 0, spacing_m: [10, 10] };
assert.equal(heightAt([1, 2, 3, 4, 5, 6], bed, [19, 11]), 6);
assert.ok(Number.isNaN(heightAt([1, 2, 3, 4, 5, 6], bed, [40, 0])));

// The row of small views takes what a large picture of 16:9 leaves: at 1920 x 1080 beside the panel, 70 % of the screen.
const row = strip(1920 - 304, 1080 - 45, 10);
assert.deepEqual([row.columns, row.rows], [10, 1]);
const tall = 1080 - 45 - row.row_px;
assert.ok((Math.min(tall * (16 / 9), 1616) * Math.min(tall, 1616 * (9 / 16))) / (1920 * 1080) >= 0.7);
assert.deepEqual(strip(1000, 600, 0), { columns: 1, rows: 0, row_px: 0 });
assert.ok(strip(1000, 1400, 10).rows > 1);

// Contours of a cone are circles: all of their points are at one distance from its top.
const side = 41;
const cone = Float32Array.from(
  { length: side * side },
  (_, k) => -Math.hypot((k % side) - 20, Math.floor(k / side) - 20),
);
const grid = { rows: side, columns: side, west_m: -20, south_m: -20, spacing_m: [1, 1] };
const lines = contours(cone, grid, 0);
assert.deepEqual(
  lines.map(({ depth }) => depth),
  [5, 10, 15, 20, 25],
);
for (const { depth, segments } of lines)
  for (const [x0, y0, x1, y1] of segments) {
    near(Math.hypot(x0, y0), depth, 0.1);
    near(Math.hypot(x1, y1), depth, 0.1);
  }

// A vehicle off the chart is pointed to; waypoints at one place share their mark.
const view = new ChartFrame();
[view.size, view.scale] = [[800, 600], 10];
assert.equal(wayTo(view, [10, 10]), null);
const way = wayTo(view, [0, -100]);
near(Math.abs(way.bearing_deg), 180, 1e-9);
near(way.away_m, 100, 1e-9);
assert.ok(way.at[1] < 600 && way.at[1] > 500);
assert.deepEqual(
  together([[0, 0], [9, 0], [0.5, 0]], view).map(({ numbers }) => numbers), // prettier-ignore
  [[1, 3], [2]],
);

// A triangle hides what lies behind it, not what lies before it or beside it.
const triangle = [5, -1, -1, 5, 1, -1, 5, 0, 2];
assert.ok(crosses(triangle, null, [0, 0, 0], [10, 0, 0]));
assert.ok(!crosses(triangle, [0, 1, 2], [0, 0, 0], [4, 0, 0]));
assert.ok(!crosses(triangle, [0, 1, 2], [0, 3, 0], [10, 3, 0]));

// The small view that has waited longest is next, however often and in whatever order the views are shown anew.
{
  const { setTimeout: later } = globalThis;
  const timers = [];
  globalThis.setTimeout = /** @type {any} */ ((act) => timers.push(act));
  const served = [];
  const streams = ['front', 'down', 'chase'].map((topic) => {
    const picture = Object.assign(new EventTarget(), { topic: '', show: (wanted) => wanted && served.push(wanted) });
    return { topic, picture };
  });
  const previews = new Previews();
  for (let k = 0; k < 30; k += 1) {
    previews.show(k % 4 ? [...streams] : streams.toReversed());
    streams.find(({ topic }) => topic === served.at(-1))?.picture.dispatchEvent(new Event('drawn'));
    if (k % 2) timers.at(-1)();
  }
  for (let k = 0; k + 3 <= served.length; k += 1) assert.equal(new Set(served.slice(k, k + 3)).size, 3);
  assert.ok(served.length >= 30);
  globalThis.setTimeout = later;
}
