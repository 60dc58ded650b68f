// The values in recorded pictures and in the metadata of snapshots: those of the vehicle's instruments, in SI units.
import { attitude } from './attitude.js';
import { clockText, fixed } from './dom.js';
import { STRINGS } from './strings.js';
import { GAUGES } from './wire/messages.js';

const WORDS = STRINGS.overlay;
export const BAND_PX = 60; // below the picture, so that nothing is hidden
const BIG = GAUGES.filter(({ list }) => list === 'big');
const INK = '#f2f8fb';
const COMMENT_INK = '#ffd166';
const ROOM_PX = 14;

const length = (metres) => (metres === null ? '–' : `${fixed(metres, 1)} m`);
const known = (value, digits) => (Number.isFinite(value) ? +value.toFixed(digits) : null);

// The values of the telemetry, null where no instrument measures them; identical to those in the server's snapshots.
export function instruments(message, time_s) {
  const isPlaced = Boolean(message) && [...message.position].every(Number.isFinite);
  return {
    time_s: known(time_s, 3),
    ...Object.fromEntries(BIG.map(({ name, column }) => [column, known(message?.[name], 2)])),
    heading_deg: isPlaced ? Number(known(attitude(message.orientation).heading_deg, 1)) % 360 : null,
    position_m: isPlaced ? [...message.position].map((value) => known(value, 2)) : null,
  };
}

/** Two lines: position and time, then the instruments' values. old_s: the age of the values, 0 while they are fresh.
 * @returns {[string, string]}
 */
export function overlayLines({ scenario, vehicle, view }, values, old_s = 0) {
  const { heading_deg: heading, position_m: at } = values;
  return [
    [scenario, vehicle, view, clockText(values.time_s ?? NaN, 1), old_s > 0 ? WORDS.old(fixed(old_s, 0)) : '']
      .filter(Boolean)
      .join(' · '),
    WORDS.values(
      length(values.depth_m),
      length(values.altitude_m),
      heading === null ? '–' : `${String(Math.round(heading) % 360).padStart(3, '0')}°`,
      at ? fixed(at[0], 1) : '–',
      at ? fixed(at[1], 1) : '–',
    ),
  ];
}

// Draw the lines and the comment into the band below the picture.
export function burn(context, [where, values], comment) {
  const { width, height } = context.canvas;
  context.fillStyle = '#05080a';
  context.fillRect(0, height - BAND_PX, width, BAND_PX);
  context.font = `600 18px ${getComputedStyle(document.body).fontFamily}`;
  context.textBaseline = 'middle';
  context.fillStyle = INK;
  context.textAlign = 'left';
  context.fillText(values, ROOM_PX, height - 43, width - 2 * ROOM_PX);
  context.fillText(where, ROOM_PX, height - 17, 0.5 * width - ROOM_PX);
  context.fillStyle = COMMENT_INK;
  context.textAlign = 'right';
  context.fillText(comment, width - ROOM_PX, height - 17, 0.5 * width - 2 * ROOM_PX);
}
