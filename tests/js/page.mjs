// The page's logic that needs neither a document nor a server. node page.mjs
import assert from 'node:assert/strict';

import { shownHolds, switched } from '../../python/uwsim/operator/station/page/drive/holds.js';

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
assert.deepEqual(shownHolds({}), []); // a server of another version
