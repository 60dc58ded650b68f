// The joints of the vehicle's arm: their positions, and a slider each, which commands where a motor turns to; the part
// that the driving keys move, and buttons for the jaws.
import { attempt } from '../dom.js';
import { positionText } from '../drive/arm_drive.js';
import { html } from '../vendor/preact.js';

const MOMENT_MS = 250;
const STEPS = 200; // of a slider, between a joint's stops

// The name of a part of the arm as shown: its joint's, or in words.
export const partName = (part) => ({ '': 'vehicle', hand: 'hand', arm: 'Arm', grip: 'GRIP' })[part] ?? part;

export class Arm {
  #vehicle = { name: '', prefix: '', arm: /** @type {any[]} */ ([]) };
  #moved = ''; // the joint whose slider is where the pilot has put it, not where the joint is

  // drive: see ArmDrive.
  constructor(station, telemetry, drive) {
    this.station = station;
    this.telemetry = telemetry;
    this.drive = drive;
  }

  begin({ name, prefix, arm = [] }) {
    this.#vehicle = { name, prefix, arm };
  }

  #command(args) {
    attempt(this.station.command('set_joints', this.#vehicle.name, args));
  }

  // A button that moves the jaws while it is held; by keyboard, for a moment.
  #jaw(text, sign) {
    const grip = (isHeld) => this.drive.grip(sign, isHeld);
    const end = () => grip(false);
    const press = (event) => {
      if (event.detail > 0) return;
      grip(true);
      setTimeout(end, MOMENT_MS);
    };
    return html`
      <button type="button" onPointerDown=${() => grip(true)} onPointerUp=${end} onPointerLeave=${end}
        onPointerCancel=${end} onClick=${press}>${text}</button>
    `;
  }

  #joint(joint) {
    const at = this.telemetry.joints.get(this.#vehicle.prefix + joint.name);
    const isHeld = this.#moved === joint.name || document.activeElement?.ariaLabel === joint.name;
    const move = ({ target }) => {
      this.#moved = joint.name;
      this.#command({ positions: { [joint.name]: Number(target.value) } });
    };
    return html`
      <label key=${joint.name}>
        <span>${joint.name} <small>${at === undefined ? '–' : positionText(joint, at)}</small></span>
        <input type="range" aria-label=${joint.name} min=${joint.low} max=${joint.high}
          step=${(joint.high - joint.low) / STEPS} value=${isHeld ? undefined : at}
          onInput=${move} onChange=${() => (this.#moved = '')} />
      </label>
    `;
  }

  view(isStale) {
    const { arm } = this.#vehicle;
    const { part, parts, hasJaws } = this.drive;
    const halt = () => this.#command({ speeds: Object.fromEntries(arm.map(({ name }) => [name, 0])) });
    const choose = ({ target }) => {
      this.drive.choose(target.value);
      target.blur(); // the keys drive again
    };
    return html`
      <section id="arm" class="arm" hidden=${arm.length === 0}>
        <h2>Arm<button type="button" id="halt-arm" onClick=${halt}>Halt</button></h2>
        <label>
          <span>Keys and sticks move</span>
          <select id="arm-part" aria-label="Keys and sticks move" value=${part} onChange=${choose}>
            ${parts.map((value) => html`<option value=${value}>${partName(value)}</option>`)}
          </select>
        </label>
        <div class="row" role="group" aria-label="Jaws" hidden=${!hasJaws}>
          ${this.#jaw('Open', -1)}${this.#jaw('Close', 1)}
        </div>
        <div class="joints ${isStale ? 'is-stale' : ''}">${arm.map((joint) => this.#joint(joint))}</div>
      </section>
    `;
  }
}
