// Marks on the chart: labels, the vehicle or the way to it, waypoints, notes, the scale and the arrow to the north.
import { fixed } from '../dom.js';
import { inUnit, unitName } from '../units.js';

const SHORT = 24; // letters of a note on the chart
export const ARROW_PX = 30; // of the arrow to the north, from the left edge
const EDGE_PX = 26; // of the arrow to a vehicle that is off the chart
const SAME_PX = 12; // between waypoints that would hide each other
const STEPS = [1, 2, 5, 10, 20, 50, 100, 200, 500];

export function label(c, text, x, y, { ink, halo }) {
  c.save();
  c.textAlign = 'center';
  c.textBaseline = 'middle';
  c.strokeStyle = halo;
  c.lineWidth = 3;
  c.strokeText(text, x, y);
  c.fillStyle = ink;
  c.fillText(text, x, y);
  c.restore();
}

function arrow(c, [x, y], heading_deg, colour, points) {
  c.save();
  c.translate(x, y);
  c.rotate((heading_deg * Math.PI) / 180);
  c.beginPath();
  for (const [a, b] of points) c.lineTo(a, b);
  c.closePath();
  c.fillStyle = colour;
  c.fill();
  c.strokeStyle = '#06121c';
  c.lineWidth = 1.5;
  c.stroke();
  c.restore();
}

// An arrow at a vehicle's position, along its heading.
export const drawVessel = (c, at, heading_deg, colour) =>
  arrow(c, at, heading_deg, colour, [[0, -11], [7, 8], [0, 4], [-7, 8]]); // prettier-ignore

/** Find where the edge of the chart shows the way to a place outside of it: a pixel, the direction [degrees from north], and
 * the distance from the middle of the chart [m]; null for a place on the chart.
 * @type {(frame: import('./chart_frame.js').ChartFrame, place: number[]) => { at: [number, number], bearing_deg: number, away_m: number } | null}
 */
export function wayTo(frame, place) {
  const [x, y] = frame.at(place);
  const [width, height] = frame.size;
  if (x >= 0 && y >= 0 && x <= width && y <= height) return null;
  const [dx, dy] = [x - width / 2, y - height / 2];
  const share = Math.min((width / 2 - EDGE_PX) / Math.abs(dx || 1e-9), (height / 2 - EDGE_PX) / Math.abs(dy || 1e-9));
  return {
    at: [width / 2 + share * dx, height / 2 + share * dy],
    bearing_deg: (Math.atan2(dx, -dy) * 180) / Math.PI,
    away_m: Math.hypot(dx, dy) / frame.scale,
  };
}

// The vehicle, or at the edge an arrow to it with the distance from the chart's middle.
export function drawVehicle(c, frame, position, heading_deg, colour, colours) {
  const way = wayTo(frame, position);
  if (!way) {
    drawVessel(c, frame.at(position), heading_deg, colour);
    return;
  }
  arrow(c, way.at, way.bearing_deg, colour, [[0, -14], [9, 4], [-9, 4]]); // prettier-ignore
  const [x, y] = way.at;
  const [width, height] = frame.size;
  const text = `${fixed(inUnit(way.away_m), 0)} ${unitName()}`;
  label(c, text, x + 30 * Math.sign(width / 2 - x), y + 20 * Math.sign(height / 2 - y || 1), colours);
}

/** The waypoints with their numbers. Those that lie together have a ring each, and their numbers stand side by side.
 * @type {(points: number[][], frame: import('./chart_frame.js').ChartFrame) => { at: [number, number], numbers: number[] }[]}
 */
export function together(points, frame) {
  /** @type {{ at: [number, number], numbers: number[] }[]} */
  const found = [];
  points.forEach((point, k) => {
    const at = frame.at(point);
    const near = found.find((each) => Math.hypot(each.at[0] - at[0], each.at[1] - at[1]) < SAME_PX);
    if (near) near.numbers.push(k + 1);
    else found.push({ at, numbers: [k + 1] });
  });
  return found;
}

export function drawWaypoints(c, frame, points, reached, isLarge, colours) {
  for (const { at, numbers } of together(points, frame)) {
    numbers
      .toReversed()
      .map((number, k) => ({ number, radius: 5 + 4 * (numbers.length - 1 - k) }))
      .forEach(({ number, radius }) => {
        c.beginPath();
        c.arc(...at, radius, 0, 2 * Math.PI);
        c.fillStyle = number <= reached ? colours.flown : colours.halo;
        c.fill();
        c.strokeStyle = colours.planned;
        c.lineWidth = 2;
        c.stroke();
      });
    if (isLarge) label(c, numbers.join(', '), at[0] + 8 + 6 * numbers.length, at[1] - 8 - 4 * numbers.length, colours);
  }
}

// A pin with its number, and with its text where there is room.
export function drawNote(c, frame, { number: index, category, text, position_m }, isLarge, colours) {
  const [x, y] = frame.at(position_m);
  c.beginPath();
  c.moveTo(x, y);
  c.lineTo(x - 7, y - 13);
  c.arc(x, y - 16, 8, Math.PI - 0.4, 0.4);
  c.closePath();
  c.fillStyle = category === 'defect' || category === 'leak' ? '#ff7a66' : '#e8c22e';
  c.fill();
  c.strokeStyle = '#06121c';
  c.lineWidth = 1.2;
  c.stroke();
  label(c, String(index), x, y - 17, { ink: '#06121c', halo: 'transparent' });
  if (isLarge && text) label(c, text.length > SHORT ? `${text.slice(0, SHORT)}…` : text, x, y - 33, colours);
}

// The scale, and the arrow to the north, which is up.
// head_px, foot_px: of the upper and lower edge, which other things lie over.
export function drawScale(c, frame, colours, north, { head_px = 0, foot_px = 0 } = {}) {
  const [width, height] = frame.size;
  const step = STEPS.find((length) => length * (frame.scale / inUnit(1)) > 70) ?? 1000; // in the pilot's unit
  const long = step * (frame.scale / inUnit(1));
  c.fillStyle = colours.ink;
  c.fillRect(width / 2 - long / 2, height - 18 - foot_px, long, 3);
  label(c, `${step} ${unitName()}`, width / 2, height - 28 - foot_px, colours);
  arrow(c, [ARROW_PX, head_px + 44], 0, colours.ink, [[0, -16], [8, 12], [0, 6], [-8, 12]]); // prettier-ignore
  label(c, north, ARROW_PX, head_px + 18, colours);
}
