// Snapshots and videos of the large view. A camera's snapshot is the server's, with the instruments' values in it.
import { pen, toast } from './dom.js';
import { html, signal } from './vendor/preact.js';

const FRAMES_PER_S = 10;
const SIZE = [960, 540]; // of a video
const BITS_PER_S = 2.5e6;
const FILE_BYTES = 2e8; // then another file is begun, since the browser keeps it in memory
const KINDS = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];

export class Recorder {
  /** @type {{ value: MediaRecorder | null }} */
  #recorder = signal(null);
  #timer = 0;

  constructor(station, telemetry, views) {
    this.station = station;
    this.telemetry = telemetry;
    this.views = views;
  }

  view() {
    const isOn = this.#recorder.value !== null;
    return html`
      <button id="snapshot" type="button" title="Snapshot" onClick=${() => this.snapshot()}>Snapshot</button>
      <button id="record" type="button" title="Record" aria-pressed=${isOn} onClick=${() => this.toggle()}>
        ${isOn ? 'Stop recording' : 'Record'}
      </button>
    `;
  }

  // Save the large view: a lossless picture from the server for a camera, otherwise what is displayed.
  async snapshot() {
    const { large, largeView } = this.views;
    const name = `${this.#stem(large.replaceAll('/', '-'))}.png`;
    try {
      if (largeView.isCamera) {
        const answer = await fetch(this.station.href(`/snapshot/${encodeURIComponent(large)}.png`));
        if (!answer.ok) throw new Error(`${answer.status} ${await answer.text()}`.trim());
        save(await answer.blob(), name);
      } else this.#shownCanvas((canvas) => canvas.toBlob((blob) => save(blob, name)));
      toast(`Saved ${name}`);
    } catch (error) {
      toast(`No snapshot: ${error.message}`, 'error');
    }
  }

  // Call a function with the large view's canvas while the canvas still contains its picture.
  #shownCanvas(take) {
    const { large, largeView } = this.views;
    const own = this.views.drawn.find(({ name }) => name === large);
    if (own?.picture) own.picture(take);
    else take(own?.canvas ?? largeView.element.querySelector('canvas'));
  }

  toggle() {
    if (this.#recorder.value) this.#stop();
    else this.#start();
  }

  #start() {
    const type = globalThis.MediaRecorder && KINDS.find((kind) => MediaRecorder.isTypeSupported(kind));
    if (!type) {
      toast('This browser cannot record pictures', 'error');
      return;
    }
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = SIZE;
    const options = { mimeType: type, videoBitsPerSecond: BITS_PER_S };
    const recorder = new MediaRecorder(canvas.captureStream(FRAMES_PER_S), options);
    const name = `${this.#stem('run')}.${type.includes('mp4') ? 'mp4' : 'webm'}`;
    const chunks = [];
    let bytes = 0;
    recorder.ondataavailable = ({ data }) => {
      chunks.push(data);
      bytes += data.size;
      if (recorder !== this.#recorder.value || bytes < FILE_BYTES) return;
      this.#stop();
      this.#start();
    };
    recorder.onstop = () => {
      if (bytes) save(new Blob(chunks, { type }), name);
      toast(bytes ? `Saved ${name}` : 'The browser had not yet recorded a picture', bytes ? 'info' : 'error');
    };
    recorder.start(1000);
    this.#compose(canvas); // a busy page may call the timer late
    this.#timer = setInterval(() => this.#compose(canvas), 1000 / FRAMES_PER_S);
    this.#recorder.value = recorder;
  }

  #stop() {
    clearInterval(this.#timer);
    this.#recorder.value?.stop();
    this.#recorder.value = null;
  }

  // Draw the large view with its head-up display.
  #compose(target) {
    const context = pen(target);
    context.fillStyle = '#05080a';
    context.fillRect(0, 0, target.width, target.height);
    this.#shownCanvas((canvas) => paste(context, canvas));
    const hud = this.views.largeView?.element.querySelector('canvas.hud');
    if (hud) paste(context, hud);
  }

  #stem(what) {
    return `${this.station.description?.scenario ?? 'uwsim'}-${what}-${Math.round(this.telemetry.stamp_s || 0)}s`;
  }
}

// Draw a canvas in the middle, as large as fits.
function paste(context, canvas) {
  if (!canvas.width || !canvas.height) return;
  const fit = Math.min(SIZE[0] / canvas.width, SIZE[1] / canvas.height);
  const [w, h] = [canvas.width * fit, canvas.height * fit];
  context.drawImage(canvas, (SIZE[0] - w) / 2, (SIZE[1] - h) / 2, w, h);
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
