// The chart's frame converts metres in the world to pixels, with panning and zooming; and functions for measuring.
export class ChartFrame {
  scale = 1; // pixels per metre
  middle = [0, 0]; // metres, in the middle of the canvas
  size = [1, 1]; // pixels

  // Show these bounds, in metres.
  fit([west, south, east, north]) {
    this.middle = [(west + east) / 2, (south + north) / 2];
    const [width, height] = this.size;
    this.scale = Math.max(Math.min(width / Math.max(east - west, 1), height / Math.max(north - south, 1)), 0.01);
  }

  /** The pixel of a place.
   * @param {number[]} place
   * @returns {[number, number]}
   */
  at([x, y]) {
    const [width, height] = this.size;
    return [width / 2 + (x - this.middle[0]) * this.scale, height / 2 - (y - this.middle[1]) * this.scale];
  }

  /** The place under a pixel.
   * @param {number[]} pixel
   * @returns {[number, number]}
   */
  place([px, py]) {
    const [width, height] = this.size;
    return [this.middle[0] + (px - width / 2) / this.scale, this.middle[1] - (py - height / 2) / this.scale];
  }

  pan(dx, dy) {
    this.middle = [this.middle[0] - dx / this.scale, this.middle[1] + dy / this.scale];
  }

  // Zoom by a factor; the place under a pixel stays there.
  zoom(factor, pixel) {
    const before = this.place(pixel);
    this.scale = Math.min(Math.max(this.scale * factor, 0.05), 400);
    const after = this.place(pixel);
    this.middle = [this.middle[0] + before[0] - after[0], this.middle[1] + before[1] - after[1]];
  }
}

/** Length [m] and compass bearing [degrees] from one place to another.
 * @type {(from: number[], to: number[]) => { length_m: number, bearing_deg: number }}
 */
export function measured([x0, y0], [x1, y1]) {
  const bearing = (Math.atan2(x1 - x0, y1 - y0) * 180) / Math.PI;
  return { length_m: Math.hypot(x1 - x0, y1 - y0), bearing_deg: (bearing + 360) % 360 };
}

export const pathLength = (points) =>
  points.slice(1).reduce((sum, point, k) => sum + Math.hypot(...point.map((value, i) => value - points[k][i])), 0);

// The height of the bed at a position, NaN outside the grid. heights: rows from the south, each from the west.
export function heightAt(heights, { rows, columns, west_m, south_m, spacing_m: [dx, dy] }, [x, y]) {
  const [i, j] = [Math.round((x - west_m) / dx), Math.round((y - south_m) / dy)];
  return i >= 0 && j >= 0 && i < columns && j < rows ? heights[j * columns + i] : NaN;
}
