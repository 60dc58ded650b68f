// The buttons of the 3D view: layers, following, viewpoints.
import { el } from '../dom.js';

const LAYERS = { terrain: 'Bed', map: 'Map', track: 'Track', fan: 'Sonar' };

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
    toggle('follows', 'Follow'),
    el('button', { type: 'button', onclick: () => look(false) }, 'Behind'),
    el('button', { type: 'button', onclick: () => look(true) }, 'Above'),
  ];
}
