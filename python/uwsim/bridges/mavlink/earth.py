"""Conversion between the world frame (ENU) and MAVLink's NED frame, latitude and longitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.georeference import HOME as HOME
from uwsim.mapping.files.georeference import Place

if TYPE_CHECKING:
    from uwsim.scenario import Scenario

Vector = NDArray[np.float64]

NED_FROM_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD = np.array([1.0, -1.0, -1.0])
"""Factors that convert body axes from forward, left, up to forward, right, down, or back."""


def ned_from_frd(xyzw: Vector) -> list[float]:
    """Return the quaternion w, x, y, z from axes forward, right, down to NED, given that of the body (FLU) in ENU."""
    x, y, z, w = (math.sqrt(0.5) * xyzw).tolist()
    return [w + z, x + y, x - y, w - z]


def place_of(scenario: Scenario | None) -> Place:
    """Return where a scenario's world is on Earth: by its georeference, or at HOME without one."""
    from uwsim.scenario.georeference import georeference

    place = georeference(scenario)
    return HOME if place.crs is None else place


def euler_rad(world_from_body: Vector) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (clockwise from north) of a pose's matrix."""
    r = NED_FROM_ENU @ world_from_body[:3, :3] * FRD
    return math.atan2(r[2, 1], r[2, 2]), -math.asin(min(max(r[2, 0], -1.0), 1.0)), math.atan2(r[1, 0], r[0, 0])
