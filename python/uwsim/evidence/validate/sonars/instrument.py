"""Physics mode over a flat bottom: the depth at which half of the vertical beams are detected, and the swath."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import bisect, minimize

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.validate.sonars.table import WATERS, Cell, acoustics

PLACES, APART_M = 256, 15.0  # pings at different positions, since speckle repeats at the same position
SWATH_PLACES, SWATH_APART_M = 1024, 5.0
OUTERMOST_RAD = math.radians(75.0)  # of the beams looked at; two receivers see above the horizon, too
LOOKING_DOWN_XYZW = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def detection_rate(cell: Cell, depths_m: list[float]) -> list[float]:
    """Return the packaged sonar's detection rate straight down at each depth, without false detections."""
    sonar = _sonar(cell, beams=2, fan_rad=math.radians(0.2))
    return [float(_rates(sonar, depth_m, PLACES, APART_M).mean()) for depth_m in depths_m]


def half_detected_m(cell: Cell) -> float:
    """Return the depth at which the detection rate is one half."""
    about_m = cell.depth_m()
    return float(
        bisect(lambda m: detection_rate(cell, [m])[0] - 0.5, 0.7 * about_m, 1.4 * about_m, xtol=1e-3 * about_m)
    )


def half_detected_swath_m(cell: Cell, depth_m: float) -> float:
    """Return the swath width at a depth, between the beams with a detection rate of one half."""
    sonar = _sonar(cell, cell.fan.beams, 2 * _half_rad(cell))
    rates = _rates(sonar, depth_m, SWATH_PLACES, SWATH_APART_M)
    return 2 * depth_m * _half_detected_tangent(np.tan(sonar_angles(cell)), rates)


def _half_detected_tangent(tangents: Floats, rates: Floats) -> float:
    """Return the tangent at which a logistic curve in its square, fitted to the rates of all beams, equals one half.

    The curve is fitted because the rate may fall slowly, which makes individual crossings of one half random. The
    tangent is at most that of the fan's outermost beam.
    """
    outermost = float(tangents.max())
    squares = (tangents / outermost) ** 2

    def surprise(curve: Floats) -> float:  # negative log-likelihood
        logits = np.clip((curve[0] - squares) * curve[1], -40.0, 40.0)
        return float(np.sum(np.logaddexp(0.0, logits) - rates * logits))

    half, _ = minimize(surprise, (0.5, 10.0), method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-6}).x
    return outermost * math.sqrt(min(max(float(half), 0.0), 1.0))


def sonar_angles(cell: Cell) -> Floats:
    """Return the angles from straight down of as many beams as the fan has, up to 75 degrees."""
    return np.linspace(-_half_rad(cell), _half_rad(cell), cell.fan.beams)


def _half_rad(cell: Cell) -> float:
    return min(cell.half_fan_rad, OUTERMOST_RAD)


def flat_world(depth_m: float, half_m: float = 3000.0) -> _core.World:
    """Return a world with only a flat bottom."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), -depth_m, np.float32), 2 * half_m, (-half_m, -half_m))
    return world


def _sonar(cell: Cell, beams: int, fan_rad: float) -> _core.AcousticMultibeam:
    spec = acoustics(cell.array, cell.frequency_khz)
    spec.false_detections = False
    packaged = cell.fan
    fan = _core.MultibeamModel(
        name=packaged.name, beams=beams, field_of_view_rad=fan_rad, range_max_m=packaged.range_max_m,
        frequency_hz=packaged.frequency_hz, receiver_tilt_rad=packaged.receiver_tilt_rad,
    )  # fmt: skip
    return _core.AcousticMultibeam(fan, spec, WATERS[cell.water].core_water())


def _rates(sonar: _core.AcousticMultibeam, depth_m: float, places: int, apart_m: float) -> Floats:
    """Return each beam's detection rate, over positions along the normal of the fan."""
    scene = _core.RayScene(flat_world(depth_m))
    along_m = apart_m * (np.arange(places) - places / 2)
    pings = [sonar.ping(scene, (x, 0.0, 0.0), LOOKING_DOWN_XYZW, tick=tick) for tick, x in enumerate(along_m)]
    return np.asarray(np.mean([ping.valid for ping in pings], axis=0))
