// Each file of the page's strings has the topics and keys of the English one, no empty text, and shows the same values.
import assert from 'node:assert/strict';

import { FILES, LANGUAGES, STRINGS } from '../../python/uwsim/operator/station/page/strings.js';

const VALUE = /\{(\w+)\}|\[(\w+)(?==\w+\?|\?)/g;
const shown = (text) => new Set([...text.matchAll(VALUE)].map((found) => found[1] ?? found[2]));

function compare(path, english, other) {
  assert.equal(typeof other, typeof english, path);
  if (typeof english === 'object') {
    assert.deepEqual(Object.keys(other).toSorted(), Object.keys(english).toSorted(), path);
    for (const key of Object.keys(english)) compare(`${path}.${key}`, english[key], other[key]);
  } else {
    assert.ok(other.trim(), `${path}: is empty`);
    const given = path.match(/\((.*)\)$/)?.[1].split(', ') ?? [];
    assert.deepEqual(shown(other), new Set(given), `${path}: shows other values than its key names`);
  }
}

assert.deepEqual(LANGUAGES, ['system', ...Object.keys(FILES)]);
for (const [language, file] of Object.entries(FILES)) compare(language, FILES.en, file);

// A text is filled with its values, which are not filled again.
const { alarms, gamepadDialog, replay } = STRINGS;
assert.equal(alarms.ahead('{name}'), 'Contact ahead: {name}');
assert.deepEqual([replay.eventCount(1), replay.eventCount(2)], ['1 event', '2 events']);
assert.deepEqual([gamepadDialog.axis(3, true), gamepadDialog.axis(3, false)], ['axis 3, reversed', 'axis 3']);
