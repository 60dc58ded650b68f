// The page's Station without a browser: what it knows of its connection and of the controls. node station.mjs
import assert from 'node:assert/strict';

let now = 0;
const timers = [];
const sockets = [];
performance.now = () => now;
globalThis.setInterval = (act, periodMs) => timers.push({ act, periodMs, due: now + periodMs });
globalThis.setTimeout = (act, waitMs) => timers.push({ act, periodMs: Infinity, due: now + waitMs });
globalThis.clearTimeout = (n) => n && (timers[n - 1].due = Infinity);
globalThis.WebSocket = class {
  static OPEN = 1;
  readyState = 0;
  constructor() {
    sockets.push(this);
  }
  open() {
    this.readyState = 1;
    this.onopen();
  }
  send(text) {
    const { op, id, service } = JSON.parse(text);
    const values = { id: `c${sockets.length}`, success: true, session: 1, edition: 0 };
    if (op === 'call_service' && service !== '/station/hand_over')
      queueMicrotask(() =>
        this.onmessage?.({ data: JSON.stringify({ op: 'service_response', id, result: true, values }) }),
      );
  }
  close() {
    this.readyState = 3;
    this.onclose?.();
  }
};
const { Station } = await import('../../python/uwsim/operator/station/page/wire/station.js');

const station = new Station('ws://here/', 'Ada');
const settled = () => new Promise((resolve) => setImmediate(resolve));
const pass = async (ms, heard = null) => {
  for (const end = now + ms; now < end;) {
    now += 50;
    if (heard && now % 500 === 0) tell(heard);
    for (const timer of timers) {
      if (now < timer.due) continue;
      timer.due = now + timer.periodMs;
      timer.act();
    }
    await settled();
  }
};
const tell = (state) => {
  const msg = { phase: 'running', session: 1, edition: 0, pilot: '', pilot_silence: 0, asking: [], ...state };
  sockets.at(-1).onmessage?.({ data: JSON.stringify({ op: 'publish', topic: '/station/state', msg }) });
};

sockets[0].open();
await settled();
await pass(3000, { pilot: 'c1' });
assert(station.isPilot && station.flew && !station.isBlind);

// The network freezes: the connection stays open, and nothing arrives.
await pass(1400);
assert(station.isPilot);
await pass(400);
assert(station.connected && station.isSilent && station.isBlind && !station.isPilot && station.flew);
assert(Math.abs(station.silence_s - 1.8) < 0.3);
await pass(1000, { pilot: 'c1' }); // it thaws
assert(station.isPilot && !station.isBlind);

// A page that was itself at a standstill blames nobody.
now += 5000;
await pass(250);
assert(!station.isSilent);

// After 10 s another connection is tried. Who had the controls may take them back, and gets them only by asking.
await pass(11500);
assert(!station.connected && sockets.length > 1);
sockets.at(-1).open();
await settled();
await pass(500, { pilot: 'c1', pilot_silence: 2 }); // the server does not yet know
assert(station.flew && !station.isPilot && !station.mayTakeBack);
await pass(500, { pilot: '', lost_by: 'Ada' });
assert(station.mayTakeBack && !station.isPilot);
await pass(500, { pilot: 'other' }); // another took them
assert(!station.flew && !station.mayTakeBack);

// A pilot who gave them away is not offered them.
await pass(500, { pilot: station.id });
station.handOver('').catch(() => null);
await pass(500, { pilot: '' });
assert(!station.mayTakeBack);

// A gauge states how old its measurement is; telemetry over a modem does not carry ages.
const { ageOf, ageText } = await import('../../python/uwsim/operator/station/page/panel/panel.js');
const message = { gauges: ['depth', 'distance_to_seabed'], gauge_ages: [3, Infinity] };
assert.equal(ageText(ageOf('depth', message)), 'measured 3.0 s ago');
assert.equal(ageText(ageOf('distance_to_seabed', message)), 'no valid measurement');
assert.equal(ageText(ageOf('depth', {})), '');

// A sensor that a package adds is a row and a field of the telemetry, with its age and no entry in any table.
const { Telemetry } = await import('../../python/uwsim/operator/station/page/telemetry.js');
const { gaugeRow } = await import('../../python/uwsim/operator/station/page/panel/rows.js');
const subscribed = new Map();
const bridge = { subscribe: (topic, _type, act) => void subscribed.set(topic, act) };
const telemetry = new Telemetry({ bridge, state: {} });
telemetry.watch({ name: 'rov', telemetry: '/telemetry', sensor_gauges: '/sensor_gauges' });
const at = (sec) => ({ header: { stamp: { sec, nanosec: 0 } } });
const readings = { ...at(1), names: ['sensor light'], units: ['W/m^2'], values: [88.912], ages: [3] };
subscribed.get('/sensor_gauges')(readings);
subscribed.get('/telemetry')({ ...message, ...at(1) });
const kept = telemetry.sensors;
subscribed.get('/telemetry')({ ...message, ...at(2) });
assert.equal(telemetry.sensors, kept); // so that the rows stay
const [name, unit, read, , field] = gaugeRow(telemetry.sensors[0]);
assert.deepEqual([name, unit, read(telemetry.message, {})], ['Light', 'W/m^2', '88.91']);
assert.equal(read({ [field]: NaN }, {}), '–');
assert.equal(ageText(ageOf(field, telemetry.message)), 'measured 4.0 s ago');
process.exit(0);
