// The editor's list of meshes with stills, and their upload.
import { html, signal } from '../vendor/preact.js';
import { edit } from '../wire/messages.js';

const PART_BYTES = 384 * 1024; // of a message
const TYPES = '.glb,.obj,.stl,.ply';
const UPLOAD = 'Upload a mesh (.glb, .obj, .stl, .ply), or drop it on the chart';

export class EditorMeshes {
  #bridge;
  #href;
  #names = signal(/** @type {string[] | null} */ (null)); // null: to be asked for
  /** @type {Map<string, string>} */
  #lost = new Map(); // what an upload did not take along, by mesh

  // href(path): the address of a file of the edited scene.
  constructor(bridge, href) {
    [this.#bridge, this.#href] = [bridge, href];
  }

  // A list of the meshes, of which one is given. pick(name): called with another one.
  list(given, pick, refuse) {
    if (!this.#names.value) this.#ask().catch(refuse);
    const still = (name) => html`
      <button type="button" aria-pressed=${name === given} title=${name} onClick=${() => pick(name)}>
        <img src=${this.#href(`mesh/${name}.png`)} alt=${nameOf(name)} loading="lazy" />
        <span>${nameOf(name)}</span>
      </button>
    `;
    const upload = ({ target }) => this.upload(target.files[0]).then(pick, refuse);
    return html`
      <div class="editor-stills" role="group" aria-label="Meshes">${(this.#names.value ?? []).map(still)}</div>
      <label class="editor-upload">${UPLOAD}<input type="file" accept=${TYPES} aria-label=${UPLOAD} onChange=${upload} /></label>
      <p class="hint" role="status">${this.#lost.get(given) ?? ''}</p>
    `;
  }

  async #ask() {
    const { meshes } = await accepted(edit(this.#bridge, { action: 'meshes' }));
    this.#names.value = meshes ?? [];
  }

  // Send a file in parts; return the name by which a scenario knows it. Throws an Error with the server's reason.
  async upload(file) {
    const { name, size } = file;
    let answer;
    for (let at = 0; at < size || at === 0; at += PART_BYTES) {
      const data = await base64(file.slice(at, at + PART_BYTES));
      answer = await accepted(edit(this.#bridge, { action: 'upload', name, size, at, data }));
    }
    this.#names.value = null;
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
