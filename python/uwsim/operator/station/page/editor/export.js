// The editor's export to other simulators: a button for each, and what is left out of the archive.
import { el } from '../dom.js';
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.editor;

export class EditorExport {
  #export;

  // makeArchive(suffix): returns the editor's state with `file` and `notes`, null after a refusal. href(path): its address.
  constructor(makeArchive, href) {
    this.#export = async (suffix) => {
      const made = await makeArchive(suffix);
      if (made) this.#show(made.notes, href(made.file));
    };
    this.buttons = el('div', { className: 'downloads' });
    this.found = el('div', { role: 'status' });
    this.element = el(
      'details',
      { className: 'editor-export', name: 'editor-file' },
      el('summary', {}, WORDS.export),
      this.buttons,
      this.found,
    );
  }

  /** @param {import('../wire/messages.js').ExportFormat[]} formats */
  offer(formats) {
    this.buttons.replaceChildren(
      ...formats.map(({ suffix, simulator }) =>
        el('button', { type: 'button', onclick: () => this.#export(suffix) }, WORDS.exportFor(simulator, suffix)),
      ),
    );
  }

  clear() {
    this.found.replaceChildren();
  }

  #show(notes, address) {
    const link = el('a', { href: address, download: '' }, WORDS.archive);
    this.found.replaceChildren(link, el('ul', { tabIndex: 0 }, ...notes.map((note) => el('li', {}, note))));
    link.click();
  }
}
