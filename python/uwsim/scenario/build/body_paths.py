"""The path of a body as the core's BodyPath: a cubic spline through its points, and the time at which it is where.

The spline has a continuous curvature, so that the heading turns smoothly. How far along it the body is at a time has a
continuous derivative: either at a speed, by the length of the curve, or between times by monotone cubics (Fritsch and
Carlson 1980, SIAM J. Numer. Anal. 17(2):238), so that it never goes back.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.loose_body import BodyPath

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

SAMPLES = 64
"""Samples of each piece of the curve, between two points."""
RAMP_S = 2.0
"""How long an open path at a speed takes to reach it, at most, and to stop."""
FASTEST_M_S = 30.0
LEAST_LEVEL = 0.05
"""The least horizontal part of the direction: the heading is undefined where the line is vertical."""


class Progress(NamedTuple):
    """The curve's parameter u (m,) and its rate (m,) at times (m,)."""

    times_s: Floats
    u: Floats
    rate: Floats


def body_path(path: BodyPath, start_m: Floats, position_m: Floats, orientation_xyzw: Floats) -> _core.BodyPath:
    """Return the path of a body whose shape starts at start_m (3,).

    position_m (3,), orientation_xyzw (4,): of the body in the path's axes, x along the path. Raises ScenarioError.
    """
    from scipy.interpolate import CubicHermiteSpline  # slow to import

    curve = _curve(path, start_m)
    progress = _between_times(path, curve) if path.times_s is not None else _at_speed(path, curve)
    steps = CubicHermiteSpline(*progress)
    times = (progress.times_s[:-1, None] + np.diff(progress.times_s)[:, None] * np.linspace(0, 1, 9)).ravel()
    speed = np.linalg.norm(curve(steps(times), 1), axis=1) * steps(times, 1)
    if speed.max() > FASTEST_M_S:
        raise ScenarioError(f"path: is followed at up to {speed.max():.3g} m/s: must be at most {FASTEST_M_S:g} m/s")
    return _core.BodyPath(
        curve.x, [np.ascontiguousarray(curve.c[::-1, :, axis].T) for axis in range(3)], steps.x,
        np.ascontiguousarray(steps.c[::-1].T), path.closed, path.climbs, path.turns, position_m, orientation_xyzw,
    )  # fmt: skip


def standing(position_m: Floats, orientation_xyzw: Floats) -> _core.BodyPath:
    """Return the path of a body that stands still with this pose in the world: (3,) and (4,)."""
    here = [np.array([[at, 0.0, 0.0, 0.0]]) for at in position_m]
    return _core.BodyPath(
        [0.0, 1.0], here, [0.0, 1.0], np.zeros((1, 4)), True, False, True, np.zeros(3), orientation_xyzw
    )


def points_on(path: BodyPath, start_m: Floats) -> Floats:
    """Return points (n, 3) along the whole path. Raises ScenarioError."""
    curve = _curve(path, start_m)
    return np.asarray(curve(_sampled(curve)))


def _curve(path: BodyPath, start_m: Floats) -> CubicSpline:
    from scipy.interpolate import CubicSpline

    points = np.array([start_m, *path.points_m, *([start_m] if path.closed else [])])
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if (near := np.flatnonzero(chords < 1e-3)).size:
        place = "the start" if near[0] == 0 or path.closed else f"points_m[{near[0] - 1}]"
        raise ScenarioError(f"path: a point lies within 1 mm of {place}: must be farther away")
    u = np.concatenate([[0.0], np.cumsum(chords)])
    curve = CubicSpline(u, points, bc_type="periodic" if path.closed else "natural")
    if not path.turns and path.times_s is not None:
        return curve
    along = curve(_sampled(curve), 1)
    led = np.linalg.norm(along[:, :2] if path.turns else along, axis=1)
    if (bad := np.flatnonzero(led < LEAST_LEVEL * np.maximum(np.linalg.norm(along, axis=1), 1))).size:
        x, y, z = curve(_sampled(curve)[bad[0]])
        rule = (
            "turns back or runs straight up or down near {}: must always lead sideways, along which the body looks; "
            "turns: false keeps its heading"
            if path.turns
            else "turns back near {}: must be followed by times_s"
        )
        raise ScenarioError(f"path: {rule.format(f'({x:.3g}, {y:.3g}, {z:.3g}) m')}")
    return curve


def _sampled(curve: CubicSpline) -> Floats:
    """Return values of the parameter, SAMPLES for each piece, and the last."""
    shares = np.arange(SAMPLES) / SAMPLES
    u = (curve.x[:-1, None] + np.diff(curve.x)[:, None] * shares).ravel()
    return np.append(u, curve.x[-1])


def _at_speed(path: BodyPath, curve: CubicSpline) -> Progress:
    from scipy.integrate import cumulative_simpson

    assert path.speed_m_s is not None
    u = _sampled(curve)
    speed_by_u = np.linalg.norm(curve(u, 1), axis=1)
    length = cumulative_simpson(speed_by_u, x=u, initial=0.0)
    v, total = path.speed_m_s, float(length[-1])
    if path.closed:
        return Progress(length / v, u, v / speed_by_u)
    ramp_s = min(RAMP_S, total / v)
    end_s = total / v + ramp_s
    times = np.linspace(0.0, end_s, len(u))
    left = np.minimum(times, end_s - times)  # to the nearer end
    slow = left < ramp_s
    from_end = np.where(slow, v * left**2 / (2 * ramp_s), v * (left - ramp_s / 2))
    along = np.where(times <= end_s / 2, from_end, total - from_end)
    at = np.interp(along, length, u)
    at[0], at[-1] = u[0], u[-1]
    speed = np.where(slow, v * left / ramp_s, v)
    return Progress(times, at, speed / np.linalg.norm(curve(at, 1), axis=1))


def _between_times(path: BodyPath, curve: CubicSpline) -> Progress:
    from scipy.interpolate import PchipInterpolator

    times, u = np.array([0.0, *(path.times_s or ())]), np.asarray(curve.x)
    if not path.closed:
        rate = np.asarray(PchipInterpolator(times, u)(times, 1)) if len(times) > 2 else np.zeros(2)
        rate[0] = rate[-1] = 0.0
        return Progress(times, u, rate)
    period, length = times[-1], u[-1]
    long_times = np.concatenate([times[:-1] - period, times, times[1:] + period])
    long_u = np.concatenate([u[:-1] - length, u, u[1:] + length])
    rate = np.asarray(PchipInterpolator(long_times, long_u)(times, 1))
    return Progress(times, u, rate)
