// Each table of the page's strings has the topics, keys and parameters of the English one, and no empty text.
import assert from 'node:assert/strict';

import { LANGUAGES, TABLES } from '../../python/uwsim/operator/station/page/strings.js';

function compare(path, english, other, language) {
  const at = `${language}: ${path}`;
  assert.equal(typeof other, typeof english, `${at}: is ${typeof other}`);
  if (typeof english === 'function') assert.equal(other.length, english.length, `${at}: has other parameters`);
  else if (typeof english === 'object') {
    assert.deepEqual(Object.keys(other).toSorted(), Object.keys(english).toSorted(), at);
    for (const key of Object.keys(english)) compare(`${path}.${key}`, english[key], other[key], language);
  } else assert.ok(other.trim(), `${at}: is empty`);
}

assert.deepEqual(LANGUAGES, ['system', ...Object.keys(TABLES)]);
for (const [language, table] of Object.entries(TABLES)) compare('', TABLES.en, table, language);

// A parameter that English shows, another language shows, too: each is given a value of its own.
const marks = (text) => new Set(text.match(/§\d/g));
for (const [topic, words] of Object.entries(TABLES.en))
  for (const [key, english] of Object.entries(words)) {
    if (typeof english !== 'function' || /^(values|sheet)$/.test(key)) continue;
    const given = Array.from({ length: english.length }, (_, k) => `§${k}`);
    for (const [language, table] of Object.entries(TABLES))
      assert.deepEqual(marks(table[topic][key](...given)), marks(english(...given)), `${language}: ${topic}.${key}`);
  }
