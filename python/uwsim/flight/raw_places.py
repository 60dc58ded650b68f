"""Where the pings of a raw survey were taken: what its multibeam and its side scan share."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.georeference import Georeference
from uwsim.scenario import Scenario
from uwsim.scenario.georeference import georeference

if TYPE_CHECKING:
    from uwsim.simulator.vehicle import Vehicle

Array = NDArray[np.float64]
STILL_M_S = 0.01  # below this speed, the course is the heading


def place_of_survey(scenario: Scenario, path: Path, option: str) -> Georeference:
    """Return a scenario's place on Earth. Raises ValueError, which names option and path, if it has none."""
    place = georeference(scenario)
    if place.crs is None:
        raise ValueError(f"{option} {path}: scenario '{scenario.name}': has no place on Earth: add earth: "
                         "{latitude_deg: ..., longitude_deg: ...}")  # fmt: skip
    if place.units_per_m != 1.0:
        raise ValueError(f"{option} {path}: scenario '{scenario.name}': horizontal_scale must be 1, since a "
                         "file for surveyors has no scale")  # fmt: skip
    return place


def angles(rotation: Array) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll)."""
    pitch = math.asin(min(1.0, max(-1.0, -rotation[2, 0])))
    return math.atan2(rotation[2, 1], rotation[2, 2]), pitch, math.atan2(rotation[1, 0], rotation[0, 0])


def level_axes(yaw_rad: float) -> Array:
    """Return the axes (3, 3) of a level vehicle as rows, forward, starboard and down, in the world."""
    cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array([[cosine, sine, 0], [sine, -cosine, 0], [0, 0, -1]])


def estimated_covariance(vehicle: Vehicle, body: Array, level: Array) -> Array:
    """Return the covariance (6, 6) of a vehicle's estimate at its reference point: place [m] and rotation [rad].

    body (4, 4): the estimated pose. level (3, 3): the axes of the result, see `level_axes`.
    """
    imu = next(each for each in vehicle.sensors.values() if each.kind == "imu")
    x, y, z = np.asarray(imu.spec.position_m, np.float64)
    found = np.eye(6)  # from the IMU's centre, world axes, and the attitude, body axes
    found[:3, :3] = level
    found[3:, 3:] = level @ body[:3, :3]
    found[:3, 3:] = level @ body[:3, :3] @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])  # p = p_imu - R r
    of_filter = vehicle.navigation.shown.covariance[np.ix_([0, 1, 2, 6, 7, 8], [0, 1, 2, 6, 7, 8])]
    return np.asarray(found @ of_filter @ found.T, np.float64)


class Motion:
    """Speed and course over ground between consecutive pings."""

    def __init__(self) -> None:
        self._last: tuple[int, Array] | None = None

    def since_last(self, time_ns: int, position_m: Array, heading_rad: float) -> tuple[float, float]:
        """Return speed over ground and course since the last ping; the heading while the vehicle is still."""
        last, self._last = self._last, (time_ns, position_m.copy())
        if last is None or time_ns <= last[0]:
            return 0.0, heading_rad
        east, north = (position_m - last[1])[:2] * 1e9 / (time_ns - last[0])
        speed_m_s = math.hypot(east, north)
        return speed_m_s, math.atan2(east, north) if speed_m_s > STILL_M_S else heading_rad
