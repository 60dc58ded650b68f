// The buttons of the 3D view: layers, following, viewpoints.
import { el } from '../dom.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.scene;

const LAYERS = { terrain: WORDS.bed, map: WORDS.map, track: WORDS.track, fan: WORDS.sonar };

// layers: the visible ones of LAYERS, and whether the camera follows; changed here, and then changed() is called.
export function sceneTools(layers, changed, look) {
  const toggle = (name, text) =>
    el(
      'button',
      {
        type: 'button',
        'aria-pressed': String(layers[name]),
        'data-layer': name,
        onclick: (event) => {
          layers[name] = !layers[name];
          event.currentTarget.setAttribute('aria-pressed', String(layers[name]));
          changed();
        },
      },
      text,
    );
  return [
    ...Object.entries(LAYERS).map(([name, text]) => toggle(name, text)),
    toggle('follows', WORDS.follow),
    el('button', { type: 'button', onclick: () => look(false) }, WORDS.behind),
    el('button', { type: 'button', onclick: () => look(true) }, WORDS.above),
  ];
}
