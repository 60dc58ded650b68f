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

function apply() {
  document.documentElement.dataset.theme = theme() === 'system' ? (prefersLight.matches ? 'light' : 'dark') : theme();
  dispatchEvent(new Event('theme'));
}

prefersLight.addEventListener('change', apply);
apply();
