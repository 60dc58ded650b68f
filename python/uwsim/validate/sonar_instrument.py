"""The shipped physics mode over a flat bottom straight below: how much of it is detected, and how deep half."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import bisect

from uwsim import _core
from uwsim.scenario.sonar_spec import load_sonar
from uwsim.validate.sonar_depth import WATERS, Cell, acoustics

BEAMS, PINGS = 400, 6
FAN_RAD = math.radians(0.2)  # all beams see the bottom straight
LOOKING_DOWN_XYZW = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def detected_share(cell: Cell, depths_m: list[float]) -> list[float]:
    """Of the bottom at each depth; false detections switched off, all else as shipped."""
    shipped = load_sonar(cell.array).core_model(cell.frequency_khz)
    spec = acoustics(cell.array, cell.frequency_khz)
    spec.false_detections = False
    fan = _core.MultibeamModel(
        name=shipped.name,
        beams=BEAMS,
        field_of_view_rad=FAN_RAD,
        range_max_m=shipped.range_max_m,
        frequency_hz=shipped.frequency_hz,
    )
    sonar = _core.AcousticMultibeam(fan, spec, WATERS[cell.water].core_water())
    return [_share(sonar, _core.RayScene(flat_world(depth_m))) for depth_m in depths_m]


def half_detected_m(cell: Cell) -> float:
    """The depth at which half of the bottom is detected. Draws are the same at every depth: shares fall with it."""
    about_m = cell.stated_depth_m()
    return float(
        bisect(lambda m: detected_share(cell, [m])[0] - 0.5, 0.7 * about_m, 1.4 * about_m, xtol=1e-4 * about_m)
    )


def flat_world(depth_m: float, half_m: float = 2000.0) -> _core.World:
    """Nothing but a level bottom."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), -depth_m, np.float32), 2 * half_m, (-half_m, -half_m))
    return world


def _share(sonar: _core.AcousticMultibeam, scene: _core.RayScene) -> float:
    pings = [sonar.ping(scene, (0.0, 0.0, 0.0), LOOKING_DOWN_XYZW, tick=tick) for tick in range(PINGS)]
    return float(np.mean([ping.valid for ping in pings]))
