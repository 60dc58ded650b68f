// Snapshots with the instruments' values in their metadata, and recordings of the large view with these values below the
// picture, beside a table of the telemetry.
import { byId, pen, toast } from './dom.js';
import { BAND_PX, burn, instruments, overlayLines } from './overlay.js';
import { withText } from './png_text.js';
import { STRINGS } from './strings.js';
import { GAUGES } from './wire/messages.js';

const WORDS = STRINGS.recorder;
const FRAMES_PER_S = 10;
const SIZE = [960, 540]; // of the picture
const BITS_PER_S = 2.5e6;
const FILE_BYTES = 2e8; // then another file is begun, since the browser keeps it in memory
const FILE_ROWS = 2e5; // of the telemetry, some 8 h
const KINDS = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];
const measured = (gauges) =>
  Object.fromEntries(
    gauges.flatMap(({ name, column }) =>
      column.includes('%')
        ? ['x', 'y', 'z'].map((axis, k) => [column.replace('%', axis), (m) => m[name][k]])
        : [[column, (m) => m[name]]],
    ),
  );
const COLUMNS = {
  time_s: (m, t) => t,
  east_m: (m) => m.position[0],
  north_m: (m) => m.position[1],
  up_m: (m) => m.position[2],
  qx: (m) => m.orientation[0],
  qy: (m) => m.orientation[1],
  qz: (m) => m.orientation[2],
  qw: (m) => m.orientation[3],
  true_east_m: (m) => m.true_position[0],
  true_north_m: (m) => m.true_position[1],
  true_up_m: (m) => m.true_position[2],
  ...measured(GAUGES),
  range_warning: (m) => Number(m.range_warning),
  proximity_warning: (m) => Number(m.proximity_warning),
  collision_warning: (m) => Number(m.collision_warning),
};

export class Recorder {
  /** @type {{ rows: string[], chunks: Blob[], stem: string, recorder?: MediaRecorder, bytes?: number, timer?: number, type?: string } | null} */
  #running = null; // { recorder, chunks, bytes, rows, timer, type, stem }
  #columns = {}; // of the table: functions of the telemetry and its time, by name
  shown = []; // the lines below the last recorded picture

  // comment(): returns the comment to show in pictures.
  constructor(station, telemetry, views, comment) {
    this.station = station;
    this.telemetry = telemetry;
    this.views = views;
    this.comment = comment;
    byId('snapshot').addEventListener('click', () => this.snapshot());
    byId('record').addEventListener('click', () => this.toggle());
    telemetry.addEventListener('change', () => this.#note());
  }

  get isRunning() {
    return this.#running !== null;
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
      } else save(await this.#drawn(), name);
      toast(WORDS.saved(name));
    } catch (error) {
      toast(WORDS.noSnapshot(error.message), 'error');
    }
  }

  // A picture of a view that the page draws itself, with the same keywords as the server's pictures.
  async #drawn() {
    const { message, stamp_s } = this.telemetry;
    const values = { ...this.#about, comment: this.comment(), ...instruments(message, stamp_s) };
    const texts = { Title: `${values.scenario}: ${values.view}`, Comment: values.comment, Software: 'uwsim' };
    const blob = await new Promise((resolve) => {
      this.#shownCanvas((canvas) => canvas.toBlob(resolve));
    });
    const png = new Uint8Array(await blob.arrayBuffer());
    return new Blob([withText(png, { ...texts, uwsim: JSON.stringify(values) })], { type: 'image/png' });
  }

  get #about() {
    const { description } = this.station;
    return { scenario: description?.scenario ?? '', vehicle: this.telemetry.vehicle, view: this.views.large };
  }

  // Call a function with the large view's canvas while the canvas still contains its picture.
  #shownCanvas(take) {
    const { large, largeView } = this.views;
    const own = this.views.drawn.find(({ name }) => name === large);
    if (own?.picture) own.picture(take);
    else take(own?.canvas ?? largeView.element.querySelector('canvas'));
  }

  toggle() {
    if (this.isRunning) this.#stop();
    else this.#start();
    byId('record').setAttribute('aria-pressed', String(this.isRunning));
    byId('record').textContent = this.isRunning ? WORDS.stop : WORDS.record;
  }

  #start() {
    const type = globalThis.MediaRecorder && KINDS.find((kind) => MediaRecorder.isTypeSupported(kind));
    this.#columns = { ...COLUMNS, ...measured(this.telemetry.sensors) };
    const rows = [Object.keys(this.#columns).join()];
    if (!type) {
      this.#running = { rows, chunks: [], stem: this.#stem('run') };
      toast(WORDS.noPictures);
      return;
    }
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [SIZE[0], SIZE[1] + BAND_PX];
    const recorder = new MediaRecorder(canvas.captureStream(FRAMES_PER_S), {
      mimeType: type,
      videoBitsPerSecond: BITS_PER_S,
    });
    const chunks = [];
    const running = { recorder, chunks, bytes: 0, rows, type, stem: this.#stem('run') };
    recorder.ondataavailable = ({ data }) => {
      chunks.push(data);
      running.bytes += data.size;
      if (running === this.#running && running.bytes > FILE_BYTES) this.#continue();
    };
    recorder.start(1000);
    this.#compose(canvas); // a busy page may call the timer late
    running.timer = setInterval(() => this.#compose(canvas), 1000 / FRAMES_PER_S);
    this.#running = running;
  }

  // Save the recording so far, and continue in a new file.
  #continue() {
    const stem = this.#running?.stem;
    this.#stop();
    this.#start();
    toast(WORDS.more(stem));
  }

  #stop() {
    if (!this.#running) return;
    const { recorder, chunks, rows, timer, type, stem } = this.#running;
    this.#running = null;
    clearInterval(timer);
    save(new Blob([rows.join('\n'), '\n'], { type: 'text/csv' }), `${stem}.csv`);
    if (!recorder || !type) return;
    recorder.onstop = () => {
      const video = new Blob(chunks, { type });
      if (video.size) save(video, `${stem}.${type.includes('mp4') ? 'mp4' : 'webm'}`);
      toast(video.size ? WORDS.savedVideo(stem) : WORDS.savedWithoutVideo(stem));
    };
    recorder.stop();
  }

  // The large view with its overlays, and the values below it.
  #compose(target) {
    const context = pen(target);
    context.fillStyle = '#05080a';
    context.fillRect(0, 0, target.width, target.height);
    this.#shownCanvas((canvas) => paste(context, canvas));
    const hud = this.views.largeView?.element.querySelector('canvas.hud');
    if (hud) paste(context, hud);
    const { message, stamp_s, isStale, lag_s } = this.telemetry;
    const lines = overlayLines(this.#about, instruments(message, stamp_s), isStale ? Math.max(lag_s, 1) : 0);
    this.shown = [...lines, this.comment()];
    burn(context, lines, this.comment());
  }

  #note() {
    if (!this.#running) return;
    const { message, stamp_s } = this.telemetry;
    this.#running.rows.push(
      Object.values(this.#columns)
        .map((read) => read(message, stamp_s))
        .join(),
    );
    if (this.#running.rows.length > FILE_ROWS) this.#continue();
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
