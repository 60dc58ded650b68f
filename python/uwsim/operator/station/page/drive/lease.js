// Shows who has the controls, with a button that takes them, requests them or hands them over.
import { attempt, byId, el, write } from '../dom.js';
import { openDialog } from '../dialogs/dialog.js';

export class Lease {
  #offered = -1; // the session whose controls this page has tried to take by itself
  #refused = new Set(); // requests that the pilot has seen

  constructor(station) {
    this.station = station;
    this.button = byId('lease');
    this.button.addEventListener('click', () => this.#press());
    station.addEventListener('state', () => this.show());
    station.addEventListener('close', () => this.show());
  }

  show() {
    const {
      station: { state, id, isPilot, connected },
    } = this;
    const asks = state.asking.filter((member) => member !== id);
    const text = !connected
      ? 'Not connected'
      : isPilot
        ? asks.length
          ? `${this.station.nameOf(asks[0])} asks for the controls`
          : 'You fly'
        : state.pilot === ''
          ? 'Take the controls'
          : this.station.pilotSilence > 0
            ? `${this.station.nameOf(state.pilot)} is silent: take over`
            : state.asking.includes(id)
              ? `Asked ${this.station.nameOf(state.pilot)}`
              : `${this.station.nameOf(state.pilot)} flies`;
    write(this.button, text);
    this.button.dataset.mine = isPilot
      ? asks.length
        ? 'asked'
        : 'yes'
      : this.station.pilotSilence > 0
        ? 'silent'
        : 'no';
    this.button.disabled = !connected;
    const wish = asks.find((member) => !this.#refused.has(member));
    if (isPilot && wish && !document.querySelector('dialog[open]')) this.#offer(wish);
    for (const member of this.#refused) if (!state.asking.includes(member)) this.#refused.delete(member);
  }

  // The first page of a session flies it; a page that gives the controls away does not get them back by itself.
  takeOnce() {
    const { state, id, description } = this.station;
    if (id === '' || this.#offered === description.session) return;
    this.#offered = description.session;
    if (state.pilot === '') this.station.takeControl().catch(() => null);
  }

  async #press() {
    const { state, isPilot, id } = this.station;
    if (!isPilot) {
      await this.station.takeControl().catch(() => null); // a refusal becomes a request, which the state shows
      return;
    }
    const others = state.member_ids.filter((member) => member !== id);
    this.#open('Hand over the controls', others.length ? 'To whom?' : 'Nobody else watches.', [
      ...others.map((member) => this.#to(member, this.station.nameOf(member))),
      this.#to('', 'Nobody: let the vehicle rest'),
    ]);
  }

  #offer(member) {
    this.#refused.add(member);
    this.#open(`${this.station.nameOf(member)} asks for the controls`, 'Your keys are let go while you decide.', [
      this.#to(member, 'Hand over'),
      el('button', { type: 'button', onclick: (event) => event.target.closest('dialog').close() }, 'Keep flying'),
    ]);
  }

  #to(member, text) {
    return el(
      'button',
      {
        type: 'button',
        onclick: (event) => {
          event.target.closest('dialog').close();
          attempt(this.station.handOver(member));
        },
      },
      text,
    );
  }

  #open(title, text, buttons) {
    openDialog(
      byId('handover-dialog'),
      title,
      el('p', {}, text),
      el('hr'),
      el('div', { className: 'stack' }, ...buttons),
    );
  }
}
