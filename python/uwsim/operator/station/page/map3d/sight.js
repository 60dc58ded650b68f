// Finds what a line of sight in the 3D view meets: the meshes before the vehicle, and what lies under the pointer.
const NEAR = 0.97; // of the way to the vehicle; what is nearer to it, such as its dock, does not hide it

/** Test if a triangle mesh crosses the segment from one point to another, all in the same frame.
 * @type {(positions: ArrayLike<number>, index: ArrayLike<number> | null, from: number[], to: number[]) => boolean}
 */
export function crosses(positions, index, from, to) {
  return firstShare(positions, index, from, to) < NEAR;
}

/** The share of the way from one point to another at which it first meets a triangle mesh; Infinity if it does not.
 * @type {(positions: ArrayLike<number>, index: ArrayLike<number> | null, from: number[], to: number[]) => number}
 */
export function firstShare(positions, index, from, to) {
  let found = Infinity;
  const way = to.map((value, k) => value - from[k]);
  const count = index ? index.length : positions.length / 3;
  const corner = (k) => {
    const at = 3 * (index ? index[k] : k);
    return [positions[at], positions[at + 1], positions[at + 2]];
  };
  for (let k = 0; k + 2 < count; k += 3)
    found = Math.min(found, shareAt(corner(k), corner(k + 1), corner(k + 2), from, way));
  return found;
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// The share of the way at which it meets the triangle a, b, c, or Infinity (Moeller and Trumbore, 1997, doi:10.1080/10867651.1997.10487468).
function shareAt(a, b, c, from, way) {
  const [ab, ac] = [minus(b, a), minus(c, a)];
  const p = cross(way, ac);
  const determinant = dot(ab, p);
  if (determinant === 0) return Infinity;
  const s = minus(from, a);
  const u = dot(s, p) / determinant;
  if (u < 0 || u > 1) return Infinity;
  const q = cross(s, ab);
  const v = dot(way, q) / determinant;
  const share = dot(ac, q) / determinant;
  return v >= 0 && u + v <= 1 && share > 0 && share <= 1 ? share : Infinity;
}
