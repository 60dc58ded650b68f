// The quality of the 3D view, chosen from the measured frame time.

const SLOW_MS = 150;
const FAST_MS = 55;
const PATIENCE = 4; // frames that must agree before anything changes
// Canvas pixels per page pixel along an axis, and levels of detail left out. Both are costly with software GL.
const STEPS = [
  [1, 0],
  [1, 1],
  [0.7, 1],
  [0.5, 1],
  [0.5, 2],
];

export class Quality {
  step = 1;
  #votes = 0;

  get ratio() {
    return STEPS[this.step][0];
  }

  get bias() {
    return STEPS[this.step][1];
  }

  adapt(frame_ms) {
    if (!frame_ms) return;
    this.#votes =
      frame_ms > SLOW_MS ? Math.max(this.#votes, 0) + 1 : frame_ms < FAST_MS ? Math.min(this.#votes, 0) - 1 : 0;
    if (Math.abs(this.#votes) < PATIENCE) return;
    this.step = Math.max(0, Math.min(STEPS.length - 1, this.step + Math.sign(this.#votes)));
    this.#votes = 0;
  }
}
