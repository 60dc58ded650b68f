"""A memory of the obstacles that the sonar has seen ahead, used to decide how high to fly."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.sealed import Sealed
from uwsim.navigation.control.protocols import PingLike

WORLD = np.eye(4)  # the pose of points that are already in world coordinates


class ObstacleMemory(Sealed):
    """Stores each ping's highest echo in the corridor ahead of the vehicle.

    The corridor extends from half_width_m behind the vehicle to ahead_m in front of it, and half_width_m to either
    side. pings: capacity; once it is full, each new echo overwrites the oldest.
    """

    half_width_m: float
    ahead_m: float
    _fixed_when = "the memory is made"

    def __init__(self, half_width_m: float = 3.0, ahead_m: float = 20.0, pings: int = 300) -> None:
        self.half_width_m = half_width_m
        self.ahead_m = ahead_m
        self._ring = np.empty((pings, 3))
        self._seen = 0

    def __repr__(self) -> str:
        return f"<ObstacleMemory of {min(self._seen, len(self._ring))} peaks, {self.ahead_m:g} m ahead>"

    def add(self, ping: PingLike, position_world_m: Floats, heading_rad: float) -> None:
        """Store a ping's highest echo in the corridor, if any."""
        peak = self._highest(ping.points_sonar_m, ping.world_from_sonar, position_world_m, heading_rad)
        if peak is not None:
            self._ring[self._seen % len(self._ring)] = peak
            self._seen += 1

    def highest_m(self, position_world_m: Floats, heading_rad: float) -> float:
        """Return the height (z) of the highest stored echo in the corridor, or -inf if there is none."""
        peaks = self._ring[: min(self._seen, len(self._ring))]
        peak = self._highest(peaks, WORLD, position_world_m, heading_rad)
        return -math.inf if peak is None else peak[2]

    def _highest(
        self, points_m: NDArray[Any], world_from_points: NDArray[Any], position_world_m: Floats, heading_rad: float
    ) -> tuple[float, float, float] | None:
        """Return the highest of the points (n, 3) in the corridor; NaN points are ignored."""
        return _core.highest_in_corridor(
            points_m, world_from_points, position_world_m, heading_rad, self.half_width_m, self.ahead_m
        )
