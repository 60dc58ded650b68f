// Requests a frame only when the last one has left the graphics queue, and measures how long that took. Software GL
// draws in a separate process; without this gate, its queue would grow and delay pictures and keys.

const SMOOTHING = 0.2;

export class FrameGate {
  frame_ms = 0; // smoothed: from the request of a frame to its end
  frames = 0;
  #fence = null;
  #begunMs = 0;

  constructor(gl) {
    this.gl = gl;
  }

  get isOpen() {
    if (!this.#fence) return true;
    const { gl } = this;
    const status = gl.clientWaitSync(this.#fence, 0, 0);
    if (status === gl.TIMEOUT_EXPIRED) return false;
    gl.deleteSync(this.#fence);
    this.#fence = null;
    if (status !== gl.WAIT_FAILED) {
      const ms = performance.now() - this.#begunMs;
      this.frame_ms = this.frame_ms ? this.frame_ms + SMOOTHING * (ms - this.frame_ms) : ms;
      this.frames += 1;
    }
    return true;
  }

  begin() {
    this.#begunMs = performance.now();
  }

  end() {
    const { gl } = this;
    this.#fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }
}
