// The direction of a camera's axis, from the vehicle's attitude, the camera's mount and the angles of its motor.
import { attitude } from '../attitude.js';

const RAD = Math.PI / 180;
const LEVEL = [0, 0, 0, 1];

/** @type {(a: number[], b: number[]) => number[]} */
function product([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

const about = (axis, angle_rad) => [
  ...[0, 1, 2].map((k) => (k === axis ? Math.sin(0.5 * angle_rad) : 0)),
  Math.cos(0.5 * angle_rad),
];

// pan (to port) and tilt (down) are a motor's angles [rad]; mount is yaw, pitch, roll [deg]. Return, in degrees, the
// axis's elevation (up) and roll (to starboard) in the world, and its direction from the bow (starboard, down).
export function cameraAxis(orientation, { yaw_pitch_roll_deg: mount }, { pan_rad = 0, tilt_rad = 0 } = {}) {
  const [yaw, pitch, roll] = mount.map((degrees) => degrees * RAD);
  const aboard = [about(2, yaw), about(1, pitch), about(0, roll), about(2, pan_rad), about(1, tilt_rad)].reduce(
    product,
    LEVEL,
  );
  const world = attitude(product([...orientation], aboard));
  const own = attitude(aboard);
  return {
    up_deg: world.nose_up_deg,
    roll_deg: world.roll_deg,
    starboard_deg: ((own.heading_deg - 90 + 540) % 360) - 180,
    down_deg: -own.nose_up_deg,
  };
}

// The focal length in pixels: a direction at an angle from the axis is at tan(angle) times this distance.
export const focalPixels = (width, { horizontal_fov_deg: fov_deg }) => (0.5 * width) / Math.tan(0.5 * fov_deg * RAD);

// The distance of a direction at elevation_deg below the picture's middle if the axis is at up_deg; null if far off it.
export function pixelsBelow(elevation_deg, up_deg, focal) {
  const off_deg = up_deg - elevation_deg;
  return Math.abs(off_deg) < 80 ? focal * Math.tan(off_deg * RAD) : null;
}

// The camera's direction from the bow, such as "12° starboard, 30° down".
export function axisText({ starboard_deg: side, down_deg: down }) {
  if (Math.abs(down) > 80) return `${Math.round(Math.abs(down))}° ${down > 0 ? 'down' : 'up'}`;
  const parts = [];
  if (Math.abs(side) >= 0.5) parts.push(`${Math.round(Math.abs(side))}° ${side > 0 ? 'starboard' : 'port'}`);
  if (Math.abs(down) >= 0.5) parts.push(`${Math.round(Math.abs(down))}° ${down > 0 ? 'down' : 'up'}`);
  return parts.join(', ') || 'ahead';
}
