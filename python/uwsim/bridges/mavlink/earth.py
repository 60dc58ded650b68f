"""Conversion between the world frame (ENU) and MAVLink's NED frame, latitude and longitude."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.georeference import metres_per_degree

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


class Place(Protocol):
    """The world's location on Earth; see uwsim.mapping.files.georeference.Georeference."""

    def degrees(self, position_world_m: Vector, /) -> Iterable[float]:
        """Return the latitude and longitude [deg] of a position (3,)."""

    def world_m(self, lat_deg: float, lon_deg: float, altitude_m: float, /) -> Vector:
        """Return the position (3,) of a geographic location."""


class Home(NamedTuple):
    """A location [deg] of the origin of a world that has none on Earth. The water surface there has altitude 0."""

    lat_deg: float
    lon_deg: float

    def degrees(self, position_world_m: Vector) -> tuple[float, float]:
        """Return the latitude and longitude [deg] of a position (3,)."""
        north, east = metres_per_degree(self.lat_deg)
        return self.lat_deg + position_world_m[1] / north, self.lon_deg + position_world_m[0] / east

    def world_m(self, lat_deg: float, lon_deg: float, altitude_m: float) -> Vector:
        """Return the position (3,) of a geographic location."""
        north, east = metres_per_degree(self.lat_deg)
        return np.array([(lon_deg - self.lon_deg) * east, (lat_deg - self.lat_deg) * north, altitude_m])


HOME = Home(33.810313, -118.393867)
"""The assumed origin of the world for a scenario without a georeference: a place in the sea off California."""


def place_of(scenario: Scenario | None) -> Place:
    """Return where a scenario's world is on Earth: by its georeference, or at HOME without one."""
    from uwsim.scenario.georeference import georeference

    place = georeference(scenario)
    return HOME if place.crs is None else place


def euler_rad(world_from_body: Vector) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (clockwise from north) of a pose's matrix."""
    r = NED_FROM_ENU @ world_from_body[:3, :3] * FRD
    return math.atan2(r[2, 1], r[2, 2]), -math.asin(min(max(r[2, 0], -1.0), 1.0)), math.atan2(r[1, 0], r[0, 0])
