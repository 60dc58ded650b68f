// The rows of small views below the large one: as high as what a large picture leaves, or a little higher.
const ASPECT = 16 / 9;
const UPRIGHT = 1; // aspect of the large picture on a hand-held screen that stands: cut at its sides
const MARGIN = 0.08; // of the aspect, so that a picture that almost fits fills its area
const LEAST_PX = 72; // of a row
const SLIMMEST = 1; // aspect of a small view, whose picture is then cut at its sides
const WIDE = 1.5; // the same where a finger chooses, so that names are whole
const ROWS = 3;
const NONE = { columns: 1, rows: 0, row_px: 0 };

/** Whether a large picture fills an area of this size [px], at the cost of its edges, or is shown whole between bars.
 * @type {(width: number, height: number) => boolean}
 */
export const isFilled = (width, height) => Math.abs(Math.log(width / height / ASPECT)) < MARGIN;

/** The columns and the height of a row for `count` small views in an area of this size [px].
 * @type {(width: number, height: number, count: number) => { columns: number, rows: number, row_px: number }}
 */
export function strip(width, height, count) {
  return fitted(width, Math.max(height - width / ASPECT, LEAST_PX), count);
}

/** The same on a hand-held screen: no row where the large picture leaves none.
 * @type {typeof strip}
 */
export function folded(width, height, count) {
  const rest = height - width / (height > width ? UPRIGHT : ASPECT);
  return rest < LEAST_PX ? NONE : fitted(width, rest, count);
}

/** The same while its bar is unfolded, when a finger chooses among all views.
 * @type {typeof strip}
 */
export const unfolded = (width, height, count) => fitted(width, height / 2, count, WIDE);

// A measure of the area of one view, where the width of all is given.
const area = ({ row_px, columns }) => row_px / columns;

function fitted(width, rest, count, slimmest = SLIMMEST) {
  if (count === 0) return NONE;
  const found = Array.from({ length: Math.min(ROWS, count) }, (_, k) => {
    const columns = Math.ceil(count / (k + 1));
    const rows = Math.ceil(count / columns);
    return {
      columns: Math.max(columns, Math.floor(width / (rest / rows) / ASPECT)),
      rows,
      row_px: Math.floor(Math.min(rest / rows, width / columns / slimmest)),
    };
  });
  const high = found.filter(({ row_px }) => row_px >= LEAST_PX);
  return (high.length ? high : found).reduce((best, each) => (area(each) > area(best) ? each : best));
}
