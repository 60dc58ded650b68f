"""Memory of the obstacles that the sonar has seen ahead; it tells a mission how high to fly."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.control.protocols import PingLike

Vector = NDArray[np.float64]


class ObstacleMemory:
    """Remembers the highest echo of each ping in the corridor ahead of the vehicle, until it has been passed.

    The corridor reaches from half_width_m behind the vehicle to ahead_m before it, half_width_m to either side.
    pings: how many are remembered.
    """

    def __init__(self, half_width_m: float = 3.0, ahead_m: float = 20.0, pings: int = 300) -> None:
        self.half_width_m = half_width_m
        self.ahead_m = ahead_m
        self._ring = np.empty((pings, 3))
        self._seen = 0

    @property
    def peaks_world_m(self) -> Vector:
        """The remembered echoes, (n, 3), the oldest first."""
        held, next_place = min(self._seen, len(self._ring)), self._seen % len(self._ring)
        return np.roll(self._ring, -next_place, axis=0)[-held:] if held == len(self._ring) else self._ring[:held].copy()

    def restore(self, peaks_world_m: Sequence[Sequence[float]] | Vector) -> None:
        """Remember these echoes (n, 3), the oldest first, and no others. Raises ValueError."""
        peaks = np.asarray(peaks_world_m, np.float64).reshape(-1, 3)
        if len(peaks) > len(self._ring) or not np.isfinite(peaks).all():
            raise ValueError(f"lookout: {len(peaks)} peaks: must be at most {len(self._ring)}, and finite")
        self._ring[: len(peaks)] = peaks
        self._seen = len(peaks)

    def add(self, ping: PingLike, position_world_m: Vector, heading_rad: float) -> None:
        """Remember the highest echo of a ping in the corridor, if there is one."""
        rotation, origin = ping.world_from_sonar[:3, :3], ping.world_from_sonar[:3, 3]
        points = ping.points_sonar_m @ rotation.T + origin
        ahead = self._in_corridor(points, position_world_m, heading_rad) & np.isfinite(ping.ranges_m)
        if ahead.any():
            heights = np.where(ahead, points[:, 2], -np.inf)
            self._ring[self._seen % len(self._ring)] = points[heights.argmax()]
            self._seen += 1

    def highest_m(self, position_world_m: Vector, heading_rad: float) -> float:
        """Height (z) of the highest remembered echo in the corridor; -inf if there is none."""
        peaks = self._ring[: min(self._seen, len(self._ring))]
        return float(peaks[self._in_corridor(peaks, position_world_m, heading_rad), 2].max(initial=-np.inf))

    def _in_corridor(self, points_world_m: Vector, position_world_m: Vector, heading_rad: float) -> NDArray[np.bool_]:
        """Which of the points (n, 3) are in the corridor; NaN points are not."""
        dx, dy = points_world_m[:, 0] - position_world_m[0], points_world_m[:, 1] - position_world_m[1]
        cos, sin = math.cos(heading_rad), math.sin(heading_rad)
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        return np.asarray((along > -self.half_width_m) & (along < self.ahead_m) & (np.abs(across) < self.half_width_m))
