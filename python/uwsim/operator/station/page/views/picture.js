// A stream of JPEG pictures on a canvas. Only the newest picture is drawn, and then acknowledged.
import { seconds } from '../wire/rosbridge.js';

// Events: 'drawn'.
export class Picture extends EventTarget {
  /** @type {(() => void) | null} */
  #end = null;
  #topic = '';
  #isDrawing = false;
  /** @type {{ topic: string, message: any, receivedMs: number } | null} */
  #waiting = null;
  #hasCredit = false;
  arrivedMs = -Infinity;
  drawn = 0;
  shown = []; // of the last pictures: moment shown [s, simulated], arrival and drawing [ms, wall clock]

  constructor(bridge, canvas) {
    super();
    this.bridge = bridge;
    this.canvas = canvas;
    this.context = canvas.getContext('2d', { alpha: false });
  }

  get topic() {
    return this.#topic;
  }

  // Show another topic, '' for none. The last picture stays until the next one.
  show(topic, options) {
    if (topic === this.#topic) return;
    this.#end?.();
    this.#end = null;
    this.#topic = topic;
    this.#waiting = null;
    this.#hasCredit = Boolean(options?.credit);
    if (!topic) return;
    this.#end = this.bridge.subscribe(
      topic,
      'sensor_msgs/CompressedImage',
      (message) => this.#receive(topic, message),
      options,
    );
  }

  async #receive(topic, message) {
    this.#waiting = { topic, message, receivedMs: Date.now() };
    if (this.#isDrawing) return;
    this.#isDrawing = true;
    while (this.#waiting) {
      const {
        topic: from,
        message: { data, format, header },
        receivedMs,
      } = this.#waiting;
      this.#waiting = null;
      try {
        const bitmap = await createImageBitmap(
          new Blob([data], { type: `image/${/png/.test(format) ? 'png' : 'jpeg'}` }),
        );
        if (from === this.#topic) this.#draw(bitmap, header.stamp, receivedMs);
        bitmap.close();
      } catch {
        /* skip a damaged picture */
      }
      if (this.#hasCredit && from === this.#topic) this.bridge.acknowledge(from);
    }
    this.#isDrawing = false;
  }

  #draw(bitmap, stamp, receivedMs) {
    const { canvas } = this;
    if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
      [canvas.width, canvas.height] = [bitmap.width, bitmap.height];
    }
    this.context.drawImage(bitmap, 0, 0);
    this.arrivedMs = performance.now();
    this.drawn += 1;
    this.dispatchEvent(new Event('drawn'));
    this.shown = [...this.shown.slice(-499), [seconds(stamp), receivedMs, Date.now()]];
  }
}
