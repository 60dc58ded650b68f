// Shows who has the controls, with a button that takes, requests or hands over the controls, and a chip for offers.
import { attempt, byId, capital } from '../dom.js';
import { openDialog } from '../dialogs/dialog.js';
import { html, signal } from '../vendor/preact.js';

export class Lease {
  #tried = -1; // the session whose controls this page has tried to take automatically
  /** @type {{ value: string[] }} */
  #dismissed = signal([]); // offers that the pilot has dismissed

  constructor(station) {
    this.station = station;
    station.addEventListener('state', () => this.#forget());
  }

  view() {
    const { station } = this;
    const text = this.#text();
    const isMine = station.isPilot ? 'yes' : station.isSilent || this.#isUnsettled ? 'silent' : 'no';
    return html`
      ${this.#offer()}
      <button id="lease" type="button" class="lease" title=${text} data-mine=${isMine} disabled=${station.isBlind}
        onClick=${() => this.#press()}>${text}</button>
    `;
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

  // An offer that has gone may come again.
  #forget() {
    const { asking } = this.station.state;
    const isOpen = (key) => (key ? asking.includes(key) : this.station.flew);
    if (!this.#dismissed.value.every(isOpen)) this.#dismissed.value = this.#dismissed.value.filter(isOpen);
  }

  // The offer to hand over or to take back the controls. It takes no focus and releases no key.
  #offer() {
    const { station } = this;
    const dismissed = this.#dismissed.value;
    const asks = station.state.asking.find((member) => member !== station.id && !dismissed.includes(member));
    const isAsked = station.isPilot && asks;
    if (!isAsked && (!station.mayTakeBack || dismissed.includes('')))
      return html`<span id="offer" class="offer" role="status" hidden />`;
    const take = () => attempt(station.takeControl());
    const dismiss = () => (this.#dismissed.value = [...dismissed, isAsked ? asks : '']);
    return html`
      <span id="offer" class="offer" role="status">
        <span>${isAsked ? `${station.nameOf(asks)} asks for the controls` : 'You had the controls'}</span>
        ${
          isAsked
            ? this.#to(asks, 'Hand over')
            : html`<button type="button" class="primary" onClick=${take}>Take them back</button>`
        }
        <button type="button" aria-label="Dismiss" onClick=${dismiss}>✕</button>
      </span>
    `;
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
      () => html`
      <p>${others.length ? 'To whom?' : 'No one else is watching.'}</p>
      <hr />
      <div class="stack">
        ${others.map((member) => this.#to(member, this.station.nameOf(member)))}
        ${this.#to('', 'No one: stop the vehicle')}
      </div>
    `,
    );
  }

  #to(member, text) {
    const give = (event) => {
      event.target.closest('dialog')?.close();
      attempt(this.station.handOver(member));
    };
    return html`<button type="button" onClick=${give}>${text}</button>`;
  }
}
