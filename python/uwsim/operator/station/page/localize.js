// The words of the document itself, which stand in its table: data-text, data-label and data-tip name a key.
import { LANGUAGE, STRINGS } from './strings.js';

const WORDS = STRINGS.document;

document.documentElement.lang = LANGUAGE;
for (const element of document.querySelectorAll('[data-text]')) element.textContent = WORDS[element.dataset.text];
for (const element of document.querySelectorAll('[data-label]'))
  element.setAttribute('aria-label', WORDS[element.dataset.label]);
for (const element of document.querySelectorAll('[data-tip]')) element.title = WORDS[element.dataset.tip];
