// Shows who has the controls, with a button that takes, requests or hands over the controls, and a chip for offers.
import { attempt, byId, capital, el, write } from '../dom.js';
import { openDialog } from '../dialogs/dialog.js';

export class Lease {
  #tried = -1; // the session whose controls this page has tried to take automatically
  #dismissed = new Set(); // offers that the pilot has dismissed
  #offered = ''; // the key of the displayed offer

  constructor(station) {
    this.station = station;
    this.button = byId('lease');
    this.offer = byId('offer');
    this.button.addEventListener('click', () => this.#press());
    station.addEventListener('state', () => this.show());
    station.addEventListener('close', () => this.show());
  }

  show() {
    const { station } = this;
    write(this.button, this.#text());
    this.button.title = this.#text();
    this.button.dataset.mine = station.isPilot ? 'yes' : station.isSilent || this.#isUnsettled ? 'silent' : 'no';
    this.button.disabled = station.isBlind;
    this.#showOffer();
  }

  // The first page of a session takes the controls, unless another client is driving, the simulator has joined a
  // rosbridge whose nodes will drive, or a pilot has just lost the connection. A page that gives up the controls does
  // not get them back automatically.
  takeOnce() {
    const { state, id, description, isBlind } = this.station;
    if (id === '' || isBlind || this.#tried === description.session) return;
    this.#tried = description.session;
    const isFree = state.pilot === '' && !state.driver && (!state.lost_by || state.lost_by === this.station.name);
    if (isFree && !state.rosbridge) this.station.takeControl().catch(() => null);
  }

  get #isUnsettled() {
    const { state, pilotSilence } = this.station;
    return pilotSilence > 0 || (state.pilot === '' && Boolean(state.driver || state.lost_by));
  }

  #text() {
    const { station } = this;
    const { state } = station;
    const pilot = station.nameOf(state.pilot);
    if (!station.connected) return 'Not connected';
    if (station.isSilent) return station.flew ? 'Controls lost' : 'No data';
    if (station.isPilot) return station.description?.replay ? 'You set the time' : 'You fly';
    if (state.pilot === '') {
      if (state.driver) return `${capital(state.driver)} drives: take the controls`;
      return state.lost_by ? `${state.lost_by} lost the connection: take the controls` : 'Take the controls';
    }
    if (station.pilotSilence > 0) return `${pilot} is silent: take over`;
    return state.asking.includes(station.id) ? `Asked ${pilot}` : `${pilot} flies`;
  }

  // The offer to be shown: its text and its button. The offer takes no focus and releases no key.
  #wanted() {
    const { station } = this;
    const { asking } = station.state;
    for (const key of this.#dismissed) if (key && !asking.includes(key)) this.#dismissed.delete(key);
    if (!station.flew) this.#dismissed.delete('');
    const asks = asking.find((member) => member !== station.id && !this.#dismissed.has(member));
    if (station.isPilot && asks)
      return {
        key: asks,
        text: `${station.nameOf(asks)} asks for the controls`,
        button: this.#to(asks, 'Hand over'),
      };
    if (!station.mayTakeBack || this.#dismissed.has('')) return null;
    const take = () => attempt(station.takeControl());
    return {
      key: '',
      text: 'You had the controls',
      button: el('button', { type: 'button', className: 'primary', onclick: take }, 'Take them back'),
    };
  }

  #showOffer() {
    const wanted = this.#wanted();
    this.offer.hidden = wanted === null;
    const text = wanted?.text ?? '';
    if (text === this.#offered) return;
    this.#offered = text;
    if (!wanted) {
      this.offer.replaceChildren();
      return;
    }
    const dismiss = () => {
      this.#dismissed.add(wanted.key);
      this.show();
    };
    this.offer.replaceChildren(
      el('span', {}, text),
      wanted.button,
      el('button', { type: 'button', 'aria-label': 'Dismiss', onclick: dismiss }, '✕'),
    );
  }

  async #press() {
    const { state, isPilot, id } = this.station;
    if (!isPilot) {
      await this.station.takeControl().catch(() => null); // a refusal becomes a request, which the state shows
      return;
    }
    const others = state.member_ids.filter((member) => member !== id);
    openDialog(
      byId('handover-dialog'),
      'Hand over the controls',
      el('p', {}, others.length ? 'To whom?' : 'No one else is watching.'),
      el('hr'),
      el(
        'div',
        { className: 'stack' },
        ...others.map((member) => this.#to(member, this.station.nameOf(member))),
        this.#to('', 'No one: stop the vehicle'),
      ),
    );
  }

  #to(member, text) {
    return el(
      'button',
      {
        type: 'button',
        onclick: (event) => {
          event.target.closest('dialog')?.close();
          attempt(this.station.handOver(member));
        },
      },
      text,
    );
  }
}
