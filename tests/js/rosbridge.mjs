// roslib (1.4 or 2.x) against our rosbridge: node rosbridge.mjs URL FOLDER MODULE. Prints a JSON object of what it saw.
import { createRequire } from 'node:module';

const [url, folder, module] = process.argv.slice(2);
const ROSLIB =
  module === 'roslib1'
    ? createRequire(`${folder}/`)(module)
    : await import(`${folder}/node_modules/${module}/dist/RosLib.js`);
const seen = {};
setTimeout(() => {
  console.error('timed out after', JSON.stringify(seen));
  process.exit(3);
}, 30000);

const connect = () =>
  new Promise((resolve, reject) => {
    const ros = new ROSLIB.Ros({ url });
    ros.on('connection', () => resolve(ros));
    ros.on('error', reject);
  });
const topic = (ros, name, messageType, options = {}) => new ROSLIB.Topic({ ros, name, messageType, ...options });
const first = (t) =>
  new Promise((resolve) => {
    t.subscribe((m) => {
      t.unsubscribe();
      resolve(m);
    });
  });
const later = (call) => new Promise((resolve, reject) => call(resolve, reject));
const until = async (condition) => {
  while (!(await condition())) await new Promise((r) => setTimeout(r, 10));
};

const one = await connect();
const two = await connect();

// publish and subscribe, each compression
const scans = topic(one, 'scan', 'sensor_msgs/LaserScan');
scans.advertise();
await until(async () => (await later((ok, no) => two.getTopics(ok, no))).topics.includes('/scan'));
for (const compression of ['none', 'cbor', 'png']) {
  const heard = first(topic(two, '/scan', 'sensor_msgs/LaserScan', { compression }));
  await later((ok, no) => two.getTopics(ok, no)); // frames are in order: it subscribes before we publish
  scans.publish({ header: { frame_id: 'base_scan' }, ranges: [1.5, 2.5], range_max: 55 });
  const scan = await heard;
  seen[compression] = [scan.header.frame_id, Array.from(scan.ranges), scan.ranges.constructor.name];
}

// throttle
let count = 0;
const slow = topic(two, '/count', 'std_msgs/UInt8', { throttle_rate: 100000 });
slow.subscribe(() => {
  count += 1;
});
await later((ok, no) => two.getTopics(ok, no));
const counter = topic(one, '/count', 'std_msgs/UInt8');
for (let k = 0; k < 20; k += 1) counter.publish({ data: k });
await later((ok, no) => one.getTopics(ok, no));
await later((ok, no) => two.getTopics(ok, no));
seen.throttled = count;

// services both ways
const adder = new ROSLIB.Service({ ros: one, name: '/add', serviceType: 'demo/Add' });
adder.advertise((request, response) => {
  response.sum = request.a + request.b;
  return true;
});
await until(async () => (await later((ok, no) => two.getServices(ok, no))).includes('/add'));
const call = (name, request) =>
  later((ok, no) => new ROSLIB.Service({ ros: two, name, serviceType: 'demo/Add' }).callService(request, ok, no));
seen.sum = (await call('/add', { a: 2, b: 3 })).sum;
seen.missing = await call('/nobody', {}).then(
  () => 'answered',
  (error) => String(error),
);

// parameters
const gain = new ROSLIB.Param({ ros: two, name: 'gain' });
seen.param_missing = await later((ok, no) => gain.get(ok, no));
await later((ok, no) => gain.set({ p: 1.5 }, ok, no));
seen.param = await later((ok, no) => gain.get(ok, no));
seen.params = await later((ok, no) => two.getParams(ok, no));

// questions
seen.type = await later((ok, no) => two.getTopicType('/scan', ok, no));
seen.nodes = (await later((ok, no) => two.getNodes(ok, no))).includes('/rosapi');
seen.fields = (await later((ok, no) => two.getMessageDetails('geometry_msgs/Twist', ok, no)))[0].fieldnames;

// tf
const transform = new Promise((resolve) => {
  new ROSLIB.TFClient({
    ros: two,
    fixedFrame: 'world',
    rate: 50,
    angularThres: 0,
    transThres: 0,
    updateDelay: 1,
  }).subscribe('rov', resolve);
});
await until(
  async () =>
    await later((ok, no) =>
      two.getNodeDetails(
        '/tf2_web_republisher',
        (subscribing) => ok((subscribing.subscribing ?? subscribing).includes('/tf')),
        no,
      ),
    ),
);
topic(one, '/tf', 'tf2_msgs/TFMessage').publish({
  transforms: [
    { header: { frame_id: 'world' }, child_frame_id: 'rov', transform: { translation: { x: 3 }, rotation: { w: 1 } } },
  ],
});
seen.x = (await transform).translation.x;

// status
seen.status = await new Promise((resolve) => {
  two.on('status', (status) => resolve(status.level));
  two.callOnConnection({ op: 'subscribe', topic: '/scan', type: 'std_msgs/UInt8' });
});

// reconnect: the same object connects again, and what is subscribed anew is heard
await new Promise((resolve) => {
  two.on('close', resolve);
  two.close();
});
await new Promise((resolve) => {
  two.on('connection', resolve);
  two.connect(url);
});
const again = first(topic(two, '/again', 'std_msgs/String'));
await later((ok, no) => two.getTopics(ok, no));
topic(one, '/again', 'std_msgs/String').publish({ data: 'hello' });
seen.again = (await again).data;

one.close();
two.close();
console.log(JSON.stringify(seen));
process.exit(0);
