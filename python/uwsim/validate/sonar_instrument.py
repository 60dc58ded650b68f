"""Physics mode over a flat bottom: the depth at which half of the beams straight below are detected, and the swath."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import bisect

from uwsim import _core
from uwsim.validate.sonar_table import WATERS, Cell, acoustics

PLACES, APART_M = 256, 15.0  # pings from as many places: speckle repeats at one place
SWATH_PLACES = 32
LOOKING_DOWN_XYZW = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))
SMOOTHED_BEAMS = 9


def detection_rate(cell: Cell, depths_m: list[float]) -> list[float]:
    """Return the detection rate straight below at each depth, as packaged but without false detections."""
    sonar = _sonar(cell, beams=2, fan_rad=math.radians(0.2))
    return [float(_rates(sonar, depth_m, PLACES).mean()) for depth_m in depths_m]


def half_detected_m(cell: Cell) -> float:
    """Return the depth at which the detection rate is one half."""
    about_m = cell.depth_m()
    return float(
        bisect(lambda m: detection_rate(cell, [m])[0] - 0.5, 0.7 * about_m, 1.4 * about_m, xtol=1e-3 * about_m)
    )


def half_detected_swath_m(cell: Cell, depth_m: float) -> float:
    """Return the width of the swath at a depth: out to the beams with a detection rate of one half."""
    sonar = _sonar(cell, cell.fan.beams, 2 * cell.half_fan_rad)
    rates = _rates(sonar, depth_m, SWATH_PLACES)
    both_sides = 0.5 * (rates + rates[::-1])
    smooth = np.convolve(both_sides, np.full(SMOOTHED_BEAMS, 1 / SMOOTHED_BEAMS), mode="same")
    angles_rad = sonar_angles(cell)
    seen = angles_rad[(smooth >= 0.5) & (angles_rad > 0)]
    return 2 * depth_m * math.tan(float(seen.max(initial=0.0)))


def sonar_angles(cell: Cell) -> NDArray[np.float64]:
    """Return the angles of the beams from straight below."""
    return np.linspace(-cell.half_fan_rad, cell.half_fan_rad, cell.fan.beams)


def flat_world(depth_m: float, half_m: float = 3000.0) -> _core.World:
    """Return a world with a flat bottom only."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), -depth_m, np.float32), 2 * half_m, (-half_m, -half_m))
    return world


def _sonar(cell: Cell, beams: int, fan_rad: float) -> _core.AcousticMultibeam:
    spec = acoustics(cell.array, cell.frequency_khz)
    spec.false_detections = False
    packaged = cell.fan
    fan = _core.MultibeamModel(
        name=packaged.name,
        beams=beams,
        field_of_view_rad=fan_rad,
        range_max_m=packaged.range_max_m,
        frequency_hz=packaged.frequency_hz,
    )
    return _core.AcousticMultibeam(fan, spec, WATERS[cell.water].core_water())


def _rates(sonar: _core.AcousticMultibeam, depth_m: float, places: int) -> NDArray[np.float64]:
    """Return the detection rate of each beam, from places along the normal of the fan."""
    scene = _core.RayScene(flat_world(depth_m))
    along_m = APART_M * (np.arange(places) - places / 2)
    pings = [sonar.ping(scene, (x, 0.0, 0.0), LOOKING_DOWN_XYZW, tick=tick) for tick, x in enumerate(along_m)]
    return np.asarray(np.mean([ping.valid for ping in pings], axis=0))
