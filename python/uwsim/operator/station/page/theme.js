// Colour themes: dark, light, and night (red, to preserve night vision); by default, the system's.

const STORED = 'uwsim.theme';
export const THEMES = ['system', 'dark', 'light', 'night'];
const prefersLight = matchMedia('(prefers-color-scheme: light)');

export function theme() {
  const kept = localStorage.getItem(STORED);
  return kept && THEMES.includes(kept) ? kept : 'system';
}

export function setTheme(kind) {
  localStorage.setItem(STORED, kind);
  apply();
}

// At night a picture is grey times the colour of text: one hue, whose brightest is that colour, below that of alarms.
const svg = (name) => document.createElementNS('http://www.w3.org/2000/svg', name);
const [HOLDER, FILTER, MATRIX] = ['svg', 'filter', 'feColorMatrix'].map(svg);
HOLDER.setAttribute('class', 'visually-hidden'); // some browsers apply no filter of an element that is not displayed
HOLDER.setAttribute('aria-hidden', 'true');
FILTER.id = 'night';
FILTER.setAttribute('color-interpolation-filters', 'sRGB');
FILTER.append(MATRIX);
HOLDER.append(FILTER);
const GREY = [0.2126, 0.7152, 0.0722]; // of Rec. 709, as in CSS's grayscale()

const isNight = () => document.documentElement.dataset.theme === 'night';

addEventListener('theme', () => {
  if (!isNight()) return;
  const text = getComputedStyle(document.documentElement).getPropertyValue('--text').trim();
  const share = (k) => Number.parseInt(text.slice(k, k + 2), 16) / 255;
  const row = (k) => `${GREY.map((part) => part * share(k)).join(' ')} 0 0`;
  MATRIX.setAttribute('values', `${row(1)} ${row(3)} ${row(5)} 0 0 0 1 0`);
  document.body.append(HOLDER);
});

// At night there are no tips, since the browser's are white; another theme brings them back.
function setTips() {
  const [from, to] = isNight() ? ['title', 'data-title'] : ['data-title', 'title'];
  for (const element of document.querySelectorAll(`[${from}]`)) {
    element.setAttribute(to, element.getAttribute(from) ?? '');
    element.removeAttribute(from);
  }
}

addEventListener('theme', setTips);
new MutationObserver(() => isNight() && setTips()).observe(document, {
  subtree: true,
  childList: true,
  attributeFilter: ['title'],
});

function apply() {
  document.documentElement.dataset.theme = theme() === 'system' ? (prefersLight.matches ? 'light' : 'dark') : theme();
  dispatchEvent(new Event('theme'));
}

prefersLight.addEventListener('change', apply);
apply();
