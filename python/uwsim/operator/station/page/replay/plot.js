// The part of the time line above its slider: events, and the distance between two flights, over time.
import { pen } from '../dom.js';
const HEIGHT = 46;
const EVENTS_PX = 10;
const COLOURS = { command: '--text-soft', alarm: '--alarm', collision: '--warn' };

// from_s, to_s: the ends of the time line; inset: distance of the slider's ends from the canvas's ends [px].
export function drawPlot(canvas, { from_s, to_s, now_s, inset, events, ghost }) {
  const width = canvas.clientWidth;
  if (!width) return;
  const ratio = Math.min(devicePixelRatio || 1, 2);
  [canvas.width, canvas.height] = [Math.round(width * ratio), HEIGHT * ratio];
  const style = getComputedStyle(canvas);
  const colour = (name) => style.getPropertyValue(name);
  const c = pen(canvas);
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  const x = (time_s) => inset + ((time_s - from_s) / Math.max(to_s - from_s, 1e-9)) * (width - 2 * inset);
  if (ghost) drawDistance(c, x, ghost, colour);
  for (const { time_s, kind } of events) {
    c.fillStyle = colour(COLOURS[kind]);
    c.fillRect(x(time_s) - 1, HEIGHT - EVENTS_PX, 2, EVENTS_PX);
  }
  c.fillStyle = colour('--accent');
  c.fillRect(x(now_s) - 0.75, 0, 1.5, HEIGHT);
}

function drawDistance(c, x, { times_s: times, apart_m: apart }, colour) {
  const most = apart.reduce((a, b) => Math.max(a, b), 0.1);
  const foot = HEIGHT - EVENTS_PX - 2;
  const y = (metres) => foot - (metres / most) * (foot - 3);
  c.beginPath();
  times.forEach((time_s, k) => c.lineTo(x(time_s), y(apart[k])));
  c.strokeStyle = '#b06cff';
  c.lineWidth = 1.5;
  c.stroke();
  c.strokeStyle = colour('--line');
  c.lineWidth = 1;
  c.strokeRect(0.5, 0.5, c.canvas.clientWidth - 1, foot);
}
