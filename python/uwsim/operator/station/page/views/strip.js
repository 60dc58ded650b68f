// The row of small views below the large one: as high as what a large picture of 16:9 leaves, or a little higher.
const ASPECT = 16 / 9;
const LEAST_PX = 72; // of a row
const SLIMMEST = 1; // aspect of a small view, whose picture is then cut at its sides
const ROWS = 3;

/** The columns and the height of a row for `count` small views in an area of this size [px].
 * @type {(width: number, height: number, count: number) => { columns: number, rows: number, row_px: number }}
 */
export function strip(width, height, count) {
  if (count === 0) return { columns: 1, rows: 0, row_px: 0 };
  const rest = Math.max(height - width / ASPECT, LEAST_PX);
  const found = Array.from({ length: Math.min(ROWS, count) }, (_, k) => {
    const columns = Math.ceil(count / (k + 1));
    const rows = Math.ceil(count / columns);
    return {
      columns: Math.max(columns, Math.floor(width / (rest / rows) / ASPECT)),
      rows,
      row_px: Math.floor(Math.min(rest / rows, width / columns / SLIMMEST)),
    };
  });
  return found.reduce((best, each) => (each.row_px > best.row_px ? each : best));
}
