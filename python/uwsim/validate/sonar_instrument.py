"""Physics mode over a flat bottom straight below: the detection rate, and the depth at which it is one half."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import bisect

from uwsim import _core
from uwsim.scenario.build.multibeam import multibeam_model
from uwsim.scenario.spec.sonar import load_sonar
from uwsim.validate.sonar_depth import WATERS, Cell, acoustics

BEAMS, PINGS = 400, 6
FAN_RAD = math.radians(0.2)  # practically vertical beams
LOOKING_DOWN_XYZW = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def detection_rate(cell: Cell, depths_m: list[float]) -> list[float]:
    """Return the detection rate at each depth, as packaged but without false detections."""
    packaged = multibeam_model(load_sonar(cell.array), cell.frequency_khz)
    spec = acoustics(cell.array, cell.frequency_khz)
    spec.false_detections = False
    fan = _core.MultibeamModel(
        name=packaged.name,
        beams=BEAMS,
        field_of_view_rad=FAN_RAD,
        range_max_m=packaged.range_max_m,
        frequency_hz=packaged.frequency_hz,
    )
    sonar = _core.AcousticMultibeam(fan, spec, WATERS[cell.water].core_water())
    return [_rate(sonar, _core.RayScene(flat_world(depth_m))) for depth_m in depths_m]


def half_detected_m(cell: Cell) -> float:
    """Return the depth at which the detection rate is one half; with equal draws at every depth it falls with depth."""
    about_m = cell.stated_depth_m()
    return float(
        bisect(lambda m: detection_rate(cell, [m])[0] - 0.5, 0.7 * about_m, 1.4 * about_m, xtol=1e-4 * about_m)
    )


def flat_world(depth_m: float, half_m: float = 2000.0) -> _core.World:
    """Return a world with a flat bottom only."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), -depth_m, np.float32), 2 * half_m, (-half_m, -half_m))
    return world


def _rate(sonar: _core.AcousticMultibeam, scene: _core.RayScene) -> float:
    pings = [sonar.ping(scene, (0.0, 0.0, 0.0), LOOKING_DOWN_XYZW, tick=tick) for tick in range(PINGS)]
    return float(np.mean([ping.valid for ping in pings]))
