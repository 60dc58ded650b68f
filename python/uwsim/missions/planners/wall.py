"""Wall scan by sonar: sideways passes along a wall, facing it at a constant distance, each at its own depth and tilt.

Seen from above, the echoes of the middle beams lie on a line: the wall. Its normal gives the heading to hold, and the
distance to the line is kept constant. A pass ends after its length, where the wall ends, or at a corner. The wall must
be steep: seen from above, a tilted fan hits a slope nearer or farther away than it is at the vehicle's depth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwsim.base.arguments import require_positive
from uwsim.missions.moves import steer
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps, StoppedError, until_at
from uwsim.navigation.control.autopilot import wrap_angle

MIDDLE_SHARE = 0.5  # fraction of the fan's beams that count as the middle beams
FEWEST_ECHOES = 10
FARTHEST = 2.5  # in multiples of the distance to maintain; anything farther away is not the wall
TO_WALL_PER_S, TO_WALL_M_S = 0.5, 0.3
OFF_M, OFF_RAD, SETTLE_S = 0.3, math.radians(5.0), 90.0
CORNER_RAD = math.radians(40.0)
SLOWEST = 5.0  # time limit of a pass, in multiples of its expected duration


@dataclass(frozen=True)
class WallPass:
    """One pass. length_m: distance flown along the wall. distance_rms_m: RMS error of the distance to the wall.

    wall_ended: whether the wall ended before the full length.
    """

    depth_m: float
    tilt_deg: float
    length_m: float
    distance_rms_m: float
    wall_ended: bool


def scan_wall(
    vehicle: OwnVehicle,
    length_m: float,
    *,
    distance_m: float = 4.0,
    depths_m: Sequence[float] = (2.0, 4.0),
    tilts_deg: Sequence[float] = (-15.0, 15.0),
    speed_m_s: float = 0.3,
) -> Steps[list[WallPass]]:
    """Scan the wall that the vehicle faces, one pass per depth and tilt, moving alternately to starboard and to port.

    tilts_deg: tilts of the sonar head, positive up. Logs `pass`. Raises StoppedError if there is no wall or the vehicle
    is stuck, and ValueError for invalid arguments.
    """
    require_positive(length_m=length_m, distance_m=distance_m, speed_m_s=speed_m_s)
    passes = []
    for k, (depth_m, tilt_deg) in enumerate((d, t) for d in depths_m for t in tilts_deg):
        tilt_rad = math.radians(tilt_deg)
        vehicle.sonar.aim(tilt_rad)
        yield from _settle(vehicle, distance_m, depth_m)
        yield from until_at(vehicle.sonar, tilt_rad)
        yield from _settle(vehicle, distance_m, depth_m)
        flown = yield from _pass(vehicle, 1.0 if k % 2 else -1.0, length_m, distance_m, depth_m, tilt_deg, speed_m_s)
        vehicle.log("pass", depth_m=depth_m, tilt_deg=tilt_deg, length_m=flown.length_m, wall_ended=flown.wall_ended)
        passes.append(flown)
    return passes


def _settle(vehicle: OwnVehicle, distance_m: float, depth_m: float) -> Steps[None]:
    """Face the wall at the required distance and depth, and wait until all of these are within tolerance."""
    end_s = vehicle.time_s + SETTLE_S
    while True:
        wall = wall_ahead(vehicle, FARTHEST * distance_m)
        if wall is None:
            raise StoppedError(f"no wall is seen within {FARTHEST * distance_m:g} m ahead")
        away_m, heading_rad = wall
        pose = vehicle.pose
        off_m = max(abs(away_m - distance_m), abs(depth_m + float(pose.position_world_m[2])))
        if off_m < OFF_M and abs(wrap_angle(heading_rad - pose.yaw_rad)) < OFF_RAD:
            return
        if vehicle.time_s > end_s:
            raise StoppedError(f"stuck {off_m:.1f} m from the distance and depth to keep")
        yield from _along(vehicle, away_m - distance_m, heading_rad, 0.0, depth_m)


def _pass(
    vehicle: OwnVehicle,
    side: float,
    length_m: float,
    distance_m: float,
    depth_m: float,
    tilt_deg: float,
    speed_m_s: float,
) -> Steps[WallPass]:
    """Fly one pass along the wall, to port (side = 1) or to starboard (-1)."""
    start, first_rad = np.array(vehicle.pose.position_world_m[:2], np.float64), vehicle.pose.yaw_rad
    end_s, off_m2, flown_m, ended = vehicle.time_s + SLOWEST * length_m / speed_m_s, [], 0.0, False
    while flown_m < length_m:
        wall = wall_ahead(vehicle, FARTHEST * distance_m)
        if wall is None or abs(wrap_angle(wall[1] - first_rad)) > CORNER_RAD:
            ended = True
            break
        if vehicle.time_s > end_s:
            raise StoppedError(f"stuck {flown_m:.1f} m into a pass along the wall")
        away_m, heading_rad = wall
        off_m2.append((away_m - distance_m) ** 2)
        yield from _along(vehicle, away_m - distance_m, heading_rad, side * speed_m_s, depth_m)
        flown_m = float(np.linalg.norm(np.asarray(vehicle.pose.position_world_m[:2]) - start))
    return WallPass(depth_m, tilt_deg, flown_m, math.sqrt(float(np.mean(off_m2))) if off_m2 else math.nan, ended)


def _along(vehicle: OwnVehicle, too_far_m: float, heading_rad: float, port_m_s: float, depth_m: float) -> Steps[None]:
    """Steer for one control period along the wall, facing it and correcting the distance."""
    to_wall = min(max(TO_WALL_PER_S * too_far_m, -TO_WALL_M_S), TO_WALL_M_S)
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    yield from steer(vehicle, heading_rad, (to_wall * cos - port_m_s * sin, to_wall * sin + port_m_s * cos), -depth_m)


def wall_ahead(vehicle: OwnVehicle, farthest_m: float) -> tuple[float, float] | None:
    """Return the horizontal distance to the wall ahead and the heading that faces it.

    Returns None if no wall is seen.
    """
    ping = vehicle.sonar.ping()
    count = len(ping.ranges_m)
    margin = round(0.5 * (1.0 - MIDDLE_SHARE) * count)
    points = np.asarray(ping.points_sonar_m, np.float64)[margin : count - margin]
    points = points[np.isfinite(points[:, 0])] @ ping.world_from_sonar[:2, :3].T + ping.world_from_sonar[:2, 3]
    points = points - np.asarray(vehicle.pose.position_world_m[:2], np.float64)
    points = points[np.linalg.norm(points, axis=1) < farthest_m]
    if len(points) < FEWEST_ECHOES:
        return None
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    normal = axes[1] if float(axes[1] @ middle) > 0.0 else -axes[1]
    return float(normal @ middle), math.atan2(normal[1], normal[0])
