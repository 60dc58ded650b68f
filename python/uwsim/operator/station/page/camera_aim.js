// Turns the camera of the large view if it has a motor, or else the vehicle's first camera with a motor.
import { attempt, el } from './dom.js';

const STEP_RAD = (6 * Math.PI) / 180;
const PERIOD_MS = 200; // while held: 30 degrees per second
// Positive pan is to port, positive tilt is down.
const TURNS = {
  camUp: ['tilt', -1, '▲', 'up'],
  camDown: ['tilt', 1, '▼', 'down'],
  camLeft: ['pan', 1, '◀', 'to port'],
  camRight: ['pan', -1, '▶', 'to starboard'],
};

export class CameraAim {
  /** @type {import('./wire/messages.js').VehicleDescription | null} */
  #vehicle = null; // from the first session
  #motors = [];
  #angles = new Map(); // camera: the requested { pan, tilt }
  #timer = 0;

  constructor(station, views) {
    this.station = station;
    this.views = views;
    this.element = el(
      'div',
      { className: 'aim', role: 'group', 'aria-label': 'Turn the camera' },
      ...Object.keys(TURNS).map((action) => this.#button(action)),
      el('button', { type: 'button', 'aria-label': 'Camera straight', onclick: () => this.centre() }, '●'),
    );
    views.addEventListener('swap', () => this.#show());
  }

  begin(vehicle) {
    this.#vehicle = vehicle;
    this.#motors = vehicle.motors;
    this.#angles = new Map(this.#motors.map(({ camera }) => [camera, { pan: 0, tilt: 0 }]));
    this.#show();
  }

  // Return whether the action turned a camera.
  act(action, isHeld) {
    if (!(action in TURNS)) return false;
    clearInterval(this.#timer);
    const [axis, sign] = TURNS[action];
    if (isHeld) {
      this.#turn(axis, sign);
      this.#timer = setInterval(() => this.#turn(axis, sign), PERIOD_MS);
    }
    return true;
  }

  stop() {
    clearInterval(this.#timer);
  }

  centre() {
    const motor = this.#motor;
    if (!motor) return;
    this.#angles.set(motor.camera, { pan: 0, tilt: 0 });
    this.#aim(motor.camera);
  }

  get #isLarge() {
    return this.#motors.find(({ camera }) => this.views.large === `${this.#vehicle?.prefix}${camera}`);
  }

  get #motor() {
    return this.#isLarge ?? this.#motors[0];
  }

  #turn(axis, sign) {
    const motor = this.#motor;
    if (!motor || !this.station.isPilot) return;
    const [least, most] = motor[`${axis}_deg`].map((degrees) => (degrees * Math.PI) / 180);
    const angles = this.#angles.get(motor.camera);
    angles[axis] = Math.max(least, Math.min(most, angles[axis] + sign * STEP_RAD));
    this.#aim(motor.camera);
  }

  #aim(camera) {
    if (!this.#vehicle) return;
    const { pan, tilt } = this.#angles.get(camera);
    attempt(this.station.command('aim_camera', this.#vehicle.name, { camera, pan_rad: pan, tilt_rad: tilt }));
  }

  #button(action) {
    const [axis, turn, sign, name] = TURNS[action];
    const end = () => this.stop();
    const onpointerdown = () => this.act(action, true);
    const onclick = ({ detail }) => detail === 0 && this.#turn(axis, turn); // by keyboard
    const acts = { onpointerdown, onpointerup: end, onpointerleave: end, onpointercancel: end, onclick };
    return el('button', { type: 'button', 'aria-label': `Camera ${name}`, ...acts }, sign);
  }

  #show() {
    this.element.hidden = !this.#isLarge;
  }
}
