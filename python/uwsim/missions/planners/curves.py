"""Flight through waypoints on Dubins paths or splines, for smooth tracks and for vehicles that cannot turn on the spot.

A Dubins path is the shortest path made of straight lines and arcs of one radius (Dubins, "On curves of minimal length
with a constraint on average curvature", 1957). The spline is a cubic through all points, parametrised
by chord length, computed by SciPy; its curvature is not limited.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.interpolate import make_interp_spline

from uwsim.base.arguments import require_positive
from uwsim.base.arrays import Floats
from uwsim.missions.dubins import dubins_points
from uwsim.missions.moves import follow, turn_to
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.wayfinder import Wayfinder
from uwsim.missions.steps import Steps, StoppedError, race, wait
from uwsim.navigation.sensor_choice import altimeter

Curve = Literal["dubins", "spline"]
LOOK_PERIOD_S = 0.2
UNDER_WAY_M_S = 0.1  # at lower speeds the vehicle is turning on the spot, and objects ahead are not in its way


def fly_through(
    vehicle: OwnVehicle,
    points_world_m: Sequence[Sequence[float]] | Floats,
    *,
    curve: Curve = "dubins",
    radius_m: float = 3.0,
    altitude_m: float | None = None,
    speed_m_s: float = 0.5,
) -> Steps[Floats]:
    """Fly a curve from the vehicle's position through points (n, 3), or (n, 2) with altitude_m above the bed.

    radius_m: turning radius of the Dubins path, which begins at the vehicle's heading. Returns the path followed, (m,
    3) or (m, 2). The path does not avoid obstacles. If altitude_m is set, a vehicle with a sonar and an
    altimeter looks ahead and stops before obstacles at its height. Raises ValueError for invalid arguments,
    StoppedError if stopped.
    """
    width = 3 if altitude_m is None else 2
    points = np.asarray(points_world_m, np.float64)
    if points.ndim != 2 or points.shape[1:] != (width,) or not len(points) or not np.isfinite(points).all():
        raise ValueError(
            f"points_world_m.shape = {points.shape}: must be (n, 3), or (n, 2) with altitude_m, and finite"
        )
    if curve not in ("dubins", "spline"):
        raise ValueError(f"curve = {curve!r}: must be dubins or spline")
    whole = np.vstack([np.asarray(vehicle.pose.position_world_m, np.float64)[:width], points])
    path = dubins_path(whole, radius_m, vehicle.pose.yaw_rad) if curve == "dubins" else spline_path(whole)
    ahead = path[1] - path[0]
    yield from turn_to(vehicle, math.atan2(ahead[1], ahead[0]))
    flight = follow(vehicle, path, altitude_m=altitude_m, speed_m_s=speed_m_s)
    if altitude_m is None or not vehicle.sonars or altimeter(vehicle.sensors) is None:
        yield from flight
        return path
    lookout = Wayfinder(vehicle, altitude_m, speed_m_s)
    yield from lookout.tilt()
    yield from race(flight, _stop_before_things(lookout))
    return path


def _stop_before_things(lookout: Wayfinder) -> Steps[None]:
    """Look ahead forever. Raises StoppedError if an obstacle is in the way of the moving vehicle."""
    while True:
        lookout.look()
        if lookout.must_stop and float(lookout.vehicle.velocity.linear_body_m_s[0]) > UNDER_WAY_M_S:
            raise StoppedError(f"something is {lookout.ahead_m:.1f} m ahead, in the way of the curve")
        yield wait(LOOK_PERIOD_S)


def dubins_path(
    points_m: Sequence[Sequence[float]] | Floats, radius_m: float, start_heading_rad: float, step_m: float = 0.5
) -> Floats:
    """Return the Dubins path through points (n, 2) or (n, 3), as points at most step_m apart.

    It leaves the first point at start_heading_rad, passes the others along the bisector of the two chords, and reaches
    the last along its chord. Height is interpolated linearly between points. Raises ValueError for invalid arguments.
    """
    points = _checked(points_m, radius_m=radius_m, step_m=step_m)
    places = [
        (x, y, heading)
        for (x, y), heading in zip(points[:, :2].tolist(), _headings(points, start_heading_rad), strict=True)
    ]
    path = [points[:1]]
    for (here, there), (a, b) in zip(pairwise(places), pairwise(points), strict=True):
        flat = dubins_points(here, there, radius_m, step_m)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0), axis=1))])
        share = (along / along[-1])[1:, None]
        path.append(np.hstack([flat[1:], (a + share * (b - a))[:, 2:]]))
    return np.concatenate(path)


def spline_path(points_m: Sequence[Sequence[float]] | Floats, step_m: float = 0.5) -> Floats:
    """Return the cubic spline through points (n, 2) or (n, 3), as points about step_m apart. Raises ValueError."""
    points = _checked(points_m, step_m=step_m)
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(chords)])
    spline = make_interp_spline(lengths, points, k=min(3, len(points) - 1))
    count = max(1, math.ceil(float(lengths[-1]) / step_m))
    places = np.unique(np.concatenate([np.linspace(0.0, lengths[-1], count + 1), lengths]))
    return np.asarray(spline(places), np.float64)


def _headings(points: Floats, start_rad: float) -> list[float]:
    chords = np.diff(points[:, :2], axis=0)
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    headings = [start_rad]
    for before, after in pairwise(chords):
        middle = before + after
        middle = middle if float(np.linalg.norm(middle)) > 1e-6 else np.array([-before[1], before[0]])
        headings.append(math.atan2(middle[1], middle[0]))
    return [*headings, math.atan2(chords[-1][1], chords[-1][0])]


def _checked(points_m: Sequence[Sequence[float]] | Floats, **lengths_m: float) -> Floats:
    points = np.asarray(points_m, np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) < 2 or not np.isfinite(points).all():
        raise ValueError(f"points_m.shape = {points.shape}: must be (n, 2) or (n, 3) finite points, n at least 2")
    if (np.linalg.norm(np.diff(points[:, :2], axis=0), axis=1) < 1e-3).any():
        raise ValueError("points_m: two consecutive points coincide")
    require_positive(**lengths_m)
    return points
