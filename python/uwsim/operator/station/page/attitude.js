// Readable angles from a quaternion x, y, z, w of the body (x ahead, y to port, z up) in east, north, up.

const DEG = 180 / Math.PI;

/** @param {ArrayLike<number> & Iterable<number>} orientation */
export function attitude(orientation) {
  const [x, y, z, w] = orientation;
  const ahead = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  const roll = Math.atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y));
  return {
    heading_deg: (90 - Math.atan2(ahead[1], ahead[0]) * DEG + 360) % 360, // clockwise from north
    nose_up_deg: Math.asin(Math.max(-1, Math.min(1, ahead[2]))) * DEG,
    roll_deg: roll * DEG, // to starboard
  };
}
