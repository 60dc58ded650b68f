// Inserts the texts of the document itself: data-text, data-label and data-tip contain keys of its table.
import { all, tip } from './dom.js';
import { LANGUAGE, STRINGS } from './strings.js';

const WORDS = STRINGS.document;

document.documentElement.lang = LANGUAGE;
for (const element of all(document, '[data-text]')) element.textContent = WORDS[element.dataset.text ?? ''];
for (const element of all(document, '[data-label]'))
  element.setAttribute('aria-label', WORDS[element.dataset.label ?? '']);
for (const element of all(document, '[data-tip]')) tip(element, WORDS[element.dataset.tip ?? '']);
