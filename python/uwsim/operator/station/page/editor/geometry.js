// Where a part lies on the chart, and the values of one that is moved, turned or raised.
/** @typedef {import('../wire/messages.js').EditedPart} Part
 * @typedef {import('../wire/messages.js').FormField} Field
 * @typedef {[number, number]} Point
 */
const RAD = Math.PI / 180;
const TURN = 'yaw_pitch_roll_deg[0]'; // the column of a row that has its own direction
const HEIGHTS = new Set(['position_m[2]', 'z']); // and of one that has its own height

// Sections whose parts are vessels' starts.
export const STARTS = new Set(['starts', 'exercise_start']);

const rounded = (value) => Math.round(value * 1000) / 1000 + 0;
const angle = (degrees) => rounded(((((degrees + 180) % 360) + 360) % 360) - 180);
const rotated = ([x, y], degrees) => {
  const [c, s] = [Math.cos(degrees * RAD), Math.sin(degrees * RAD)];
  return /** @type {Point} */ ([c * x - s * y, s * x + c * y]);
};

/** @type {(part: Part, place: number[]) => Point} */
const outward = ({ frame: [x, y, yaw] }, place) => {
  const [dx, dy] = rotated(/** @type {Point} */ (place), yaw);
  return [x + dx, y + dy];
};

/** @type {(part: Part, place: Point) => Point} */
const inward = ({ frame: [x, y, yaw] }, place) => rotated([place[0] - x, place[1] - y], -yaw);

/** @type {(fields: Field[], role: string) => Field | undefined} */
const having = (fields, role) => fields.find((field) => field.role === role);

const valueOf = (part, field) => (field ? (part.values[field.name] ?? field.by_default) : null);
const isNumbers = (value) => Array.isArray(value) && value.every((each) => typeof each === 'number');

const mean = (points) =>
  /** @type {Point} */ ([0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length));

/** The corners of a part in the world.
 * @type {(part: Part, fields: Field[]) => Point[]}
 */
export function cornersOf(part, fields) {
  const rows = part.values[having(fields, 'line')?.name ?? ''];
  return Array.isArray(rows) ? rows.filter(isNumbers).map((row) => outward(part, row)) : [];
}

/** The position of a part in the world: its own, or the middle of its corners; null if it has none.
 * @type {(part: Part, fields: Field[]) => Point | null}
 */
export function placeOf(part, fields) {
  const own = valueOf(part, having(fields, 'place'));
  if (isNumbers(own)) return outward(part, own);
  const corners = cornersOf(part, fields);
  return corners.length ? mean(corners) : null;
}

/** The direction of a part in the world, degrees from east towards north; null if it has none.
 * @type {(part: Part, fields: Field[]) => number | null}
 */
export function yawOf(part, fields) {
  const own = [valueOf(part, having(fields, 'turn'))].flat()[0];
  return typeof own === 'number' ? own + part.frame[2] : null;
}

/** The values of a part moved by metres in the world. corner: the number of the only corner that moves, or -1.
 * @type {(part: Part, fields: Field[], by: Point, corner?: number) => Record<string, any>}
 */
export function moved(part, fields, [dx, dy], corner = -1) {
  const shifted = (place) => {
    const [x, y] = outward(part, place);
    return [...inward(part, [x + dx, y + dy]).map(rounded), ...place.slice(2)];
  };
  const [place, line] = [having(fields, 'place'), having(fields, 'line')];
  const own = valueOf(part, place);
  if (place && corner < 0 && isNumbers(own)) return { [place.name]: shifted(own) };
  const rows = line && part.values[line.name];
  return line && rows ? { [line.name]: rows.map((row, k) => (corner < 0 || corner === k ? shifted(row) : row)) } : {};
}

/** The values of a part turned by degrees; of one without a direction, its corners turned around their middle.
 * @type {(part: Part, fields: Field[], degrees: number) => Record<string, any>}
 */
export function turned(part, fields, degrees) {
  const turn = having(fields, 'turn');
  if (turn) {
    const own = valueOf(part, turn) ?? 0;
    const [first, ...rest] = [own].flat();
    return { [turn.name]: Array.isArray(own) ? [angle(first + degrees), ...rest] : angle(first + degrees) };
  }
  const line = having(fields, 'line');
  const rows = line && part.values[line.name];
  if (!line || !rows) return {};
  const column = line.columns.indexOf(TURN);
  if (column >= 0) return { [line.name]: rows.map((row) => row.with(column, angle(row[column] + degrees))) };
  const [x0, y0] = mean(rows);
  const around = ([x, y, ...rest]) => {
    const [dx, dy] = rotated([x - x0, y - y0], degrees);
    return [rounded(x0 + dx), rounded(y0 + dy), ...rest];
  };
  return { [line.name]: rows.map(around) };
}

/** The values of a part raised by metres; none for one that has no height.
 * @type {(part: Part, fields: Field[], dz: number) => Record<string, any>}
 */
export function raised(part, fields, dz) {
  const place = having(fields, 'place');
  const own = valueOf(part, place);
  if (place && isNumbers(own)) return own.length > 2 ? { [place.name]: own.with(2, rounded(own[2] + dz)) } : {};
  const line = having(fields, 'line');
  const [rows, column] = [line && part.values[line.name], line?.columns.findIndex((each) => HEIGHTS.has(each)) ?? -1];
  return line && rows && column >= 0
    ? { [line.name]: rows.map((row) => row.with(column, rounded(row[column] + dz))) }
    : {};
}

/** The distance from a point to the edges of a polygon; Infinity without edges.
 * @type {(polygon: number[][], point: number[]) => number}
 */
export function edgeDistance(polygon, [x, y]) {
  const away = polygon.map(([x1, y1], k) => {
    const [x0, y0] = /** @type {number[]} */ (polygon.at(k - 1));
    const [dx, dy] = [x1 - x0, y1 - y0];
    const share = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1);
    const nearest = Math.min(Math.max(share, 0), 1);
    return Math.hypot(x0 + nearest * dx - x, y0 + nearest * dy - y);
  });
  return Math.min(...away, Infinity);
}

/** True if a pixel, null for one that does not exist, lies within a canvas of a width and a height.
 * @type {(pixel: number[] | null, size: number[]) => boolean}
 */
export const isWithin = (pixel, size) => pixel !== null && pixel.every((value, k) => value >= 0 && value <= size[k]);

/** Whether a point lies inside a polygon.
 * @type {(polygon: number[][], point: Point) => boolean}
 */
export function contains(polygon, [x, y]) {
  let isInside = false;
  polygon.forEach(([x1, y1], k) => {
    const [x0, y0] = /** @type {number[]} */ (polygon.at(k - 1));
    if (y0 > y !== y1 > y && x < x0 + ((x1 - x0) * (y - y0)) / (y1 - y0)) isInside = !isInside;
  });
  return isInside;
}
