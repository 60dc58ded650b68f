// Snapshots, and recordings of the large view together with the telemetry.
import { byId, toast } from './dom.js';

const FRAMES_PER_S = 10;
const KINDS = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];
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
  speed_m_s: (m) => m.speed,
  angular_speed_rad_s: (m) => m.angular_speed,
  acceleration_x_m_s2: (m) => m.linear_acceleration[0],
  acceleration_y_m_s2: (m) => m.linear_acceleration[1],
  acceleration_z_m_s2: (m) => m.linear_acceleration[2],
  angular_acceleration_x_rad_s2: (m) => m.angular_acceleration[0],
  angular_acceleration_y_rad_s2: (m) => m.angular_acceleration[1],
  angular_acceleration_z_rad_s2: (m) => m.angular_acceleration[2],
  depth_m: (m) => m.depth,
  altitude_m: (m) => m.distance_to_seabed,
  to_station_m: (m) => m.distance_to_station,
  temperature_deg_c: (m) => m.temperature,
  pressure_pa: (m) => m.pressure,
  battery_percent: (m) => m.battery,
  range_warning: (m) => Number(m.range_warning),
  proximity_warning: (m) => Number(m.proximity_warning),
  collision_warning: (m) => Number(m.collision_warning),
};
const COLUMN_NAMES = Object.keys(COLUMNS);

export class Recorder {
  #running = null; // { recorder, chunks, rows, canvas, timer }

  constructor(station, telemetry, views) {
    [this.station, this.telemetry, this.views] = [station, telemetry, views];
    byId('snapshot').addEventListener('click', () => this.snapshot());
    byId('record').addEventListener('click', () => this.toggle());
    telemetry.addEventListener('change', () => this.#note());
  }

  get isRunning() {
    return this.#running !== null;
  }

  // Save the large view as the server renders it, without loss, and the panel's values; the 3D view as it is shown.
  async snapshot() {
    const { large } = this.views;
    const stem = this.#stem(large);
    const own = this.views.drawn.find(({ name }) => name === large);
    if (own) {
      taken(own, (canvas) => canvas.toBlob((blob) => save(blob, `${stem}.png`)));
      save(
        new Blob([JSON.stringify(plain(this.telemetry.message), null, 2)], { type: 'application/json' }),
        `${stem}.json`,
      );
      return;
    }
    try {
      for (const kind of ['png', 'json']) {
        const answer = await fetch(this.station.href(`/snapshot/${encodeURIComponent(large)}.${kind}`));
        if (!answer.ok) throw new Error(`${answer.status} ${await answer.text()}`.trim());
        save(await answer.blob(), `${stem}.${kind}`);
      }
      toast(`Saved ${stem}.png and .json`);
    } catch (error) {
      toast(`No snapshot: ${error.message}`, 'error');
    }
  }

  toggle() {
    if (this.isRunning) this.#stop();
    else this.#start();
    byId('record').setAttribute('aria-pressed', String(this.isRunning));
    byId('record').textContent = this.isRunning ? 'Stop recording' : 'Record';
  }

  #start() {
    const type = globalThis.MediaRecorder && KINDS.find((kind) => MediaRecorder.isTypeSupported(kind));
    const rows = [COLUMN_NAMES.join()];
    if (!type) {
      this.#running = { rows, chunks: [], stem: this.#stem('run') };
      toast('Recording the telemetry: this browser cannot record pictures');
      return;
    }
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [960, 540];
    const recorder = new MediaRecorder(canvas.captureStream(FRAMES_PER_S), { mimeType: type });
    const chunks = [];
    recorder.ondataavailable = ({ data }) => chunks.push(data);
    recorder.start(1000);
    const timer = setInterval(() => this.#compose(canvas), 1000 / FRAMES_PER_S);
    this.#running = { recorder, chunks, rows, timer, type, stem: this.#stem('run') };
  }

  #stop() {
    const { recorder, chunks, rows, timer, type, stem } = this.#running;
    this.#running = null;
    clearInterval(timer);
    save(new Blob([rows.join('\n'), '\n'], { type: 'text/csv' }), `${stem}.csv`);
    if (!recorder) return;
    recorder.onstop = () => save(new Blob(chunks, { type }), `${stem}.${type.includes('mp4') ? 'mp4' : 'webm'}`);
    recorder.stop();
    toast(`Saved ${stem}: video and telemetry`);
  }

  // The large view with its overlays.
  #compose(target) {
    const context = target.getContext('2d');
    context.fillStyle = '#05080a';
    context.fillRect(0, 0, target.width, target.height);
    const own = this.views.drawn.find(({ name }) => name === this.views.large);
    if (own) {
      taken(own, (drawn) => paste(context, drawn));
      return;
    }
    for (const canvas of this.views.largeView?.element.querySelectorAll('canvas') ?? []) {
      paste(context, canvas);
    }
  }

  #note() {
    if (!this.#running) return;
    const { message, stamp_s } = this.telemetry;
    this.#running.rows.push(COLUMN_NAMES.map((name) => COLUMNS[name](message, stamp_s)).join());
  }

  #stem(what) {
    return `${this.station.description?.scenario ?? 'uwsim'}-${what}-${Math.round(this.telemetry.stamp_s || 0)}s`;
  }
}

// Pass on the canvas of a view that this page draws, while it holds its picture.
function taken(view, take) {
  if (view.picture) view.picture(take);
  else take(view.canvas);
}

// Draw it as large as it fits, in the middle.
function paste(context, canvas) {
  const { canvas: target } = context;
  if (!canvas.width || !canvas.height) return;
  const fit = Math.min(target.width / canvas.width, target.height / canvas.height);
  const [w, h] = [canvas.width * fit, canvas.height * fit];
  context.drawImage(canvas, (target.width - w) / 2, (target.height - h) / 2, w, h);
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function plain(value) {
  if (ArrayBuffer.isView(value)) return [...value];
  if (value && typeof value === 'object')
    return Object.fromEntries(
      Object.entries(value).map(([key, item]) => [key, Array.isArray(item) ? item : plain(item)]),
    );
  return value;
}
