// The editor's list of meshes with stills, and their upload.
import { el } from '../dom.js';
import { edit } from '../wire/messages.js';

const PART_BYTES = 384 * 1024; // of a message
const TYPES = '.glb,.obj,.stl,.ply';

export class EditorMeshes {
  #bridge;
  #href;
  /** @type {string[] | null} */
  #names = null;
  /** @type {Map<string, string>} */
  #lost = new Map(); // what an upload did not take along, by mesh

  // href(path): the address of a file of the edited scene.
  constructor(bridge, href) {
    [this.#bridge, this.#href] = [bridge, href];
  }

  // A list of the meshes, of which one is given. pick(name): called with another one.
  list(given, pick, refuse) {
    const box = el('div', { className: 'editor-stills', role: 'group', 'aria-label': 'Meshes' });
    const still = (name) =>
      el(
        'button',
        { type: 'button', 'aria-pressed': String(name === given), title: name, onclick: () => pick(name) },
        el('img', { src: this.#href(`mesh/${name}.png`), alt: nameOf(name), loading: 'lazy' }),
        el('span', {}, nameOf(name)),
      );
    const input = el('input', {
      type: 'file',
      accept: TYPES,
      'aria-label': 'Upload a mesh (.glb, .obj, .stl, .ply), or drop it on the chart',
      onchange: ({ target }) => this.upload(target.files[0]).then(pick, refuse),
    });
    this.#known()
      .then((names) => box.replaceChildren(...names.map(still)))
      .catch(refuse);
    const lost = el('p', { className: 'hint', role: 'status' }, this.#lost.get(given) ?? '');
    return [
      box,
      el(
        'label',
        { className: 'editor-upload' },
        'Upload a mesh (.glb, .obj, .stl, .ply), or drop it on the chart',
        input,
      ),
      lost,
    ];
  }

  async #known() {
    const names = this.#names ?? (await accepted(edit(this.#bridge, { action: 'meshes' }))).meshes ?? [];
    this.#names = names;
    return names;
  }

  // Send a file in parts; return the name by which a scenario knows it. Throws an Error with the server's reason.
  async upload(file) {
    const { name, size } = file;
    let answer;
    for (let at = 0; at < size || at === 0; at += PART_BYTES) {
      const data = await base64(file.slice(at, at + PART_BYTES));
      answer = await accepted(edit(this.#bridge, { action: 'upload', name, size, at, data }));
    }
    this.#names = null;
    if (answer?.lost) this.#lost.set(answer.mesh, answer.lost);
    return answer?.mesh ?? '';
  }
}

const nameOf = (path) => path.replace(/^.*\//, '');

async function accepted(answer) {
  const found = await answer;
  if (!found.success) throw new Error(found.message);
  return found;
}

function base64(blob) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(String(reader.result).replace(/^[^,]*,/, ''));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(blob);
  });
}
