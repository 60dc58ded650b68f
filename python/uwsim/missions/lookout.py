"""How high to fly: above what lies below, and above what the sonar has seen ahead."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from uwsim.control.protocols import PingLike

Vector = NDArray[np.float64]


class Lookout:
    """Remembers the highest echo of each ping in the vehicle's way, until it has been passed."""

    def __init__(self, half_width_m: float = 3.0, ahead_m: float = 20.0, pings: int = 300) -> None:
        self.half_width_m = half_width_m
        self.ahead_m = ahead_m
        self._peaks: deque[Vector] = deque(maxlen=pings)

    def see(self, ping: PingLike, position_world_m: Vector, heading_rad: float) -> None:
        """Take in a ping."""
        echoes = ping.points_sonar_m[np.isfinite(ping.ranges_m)]
        points = echoes @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
        in_way = points[self._in_way(points, position_world_m, heading_rad)]
        if len(in_way):
            self._peaks.append(in_way[np.argmax(in_way[:, 2])])

    def highest_m(self, position_world_m: Vector, heading_rad: float) -> float:
        """Height (z) of the highest thing known in the way; -inf when there is none."""
        if not self._peaks:
            return -np.inf
        peaks = np.array(self._peaks)
        heights = peaks[self._in_way(peaks, position_world_m, heading_rad), 2]
        return float(heights.max(initial=-np.inf))

    def _in_way(self, points_world_m: Vector, position_world_m: Vector, heading_rad: float) -> NDArray[np.bool_]:
        dx, dy = (points_world_m[:, :2] - position_world_m[:2]).T
        cos, sin = np.cos(heading_rad), np.sin(heading_rad)
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        return np.asarray((along > -self.half_width_m) & (along < self.ahead_m) & (np.abs(across) < self.half_width_m))
