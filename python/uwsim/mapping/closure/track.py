"""PingTrack: the pings of a flight, stored so that the map can be rebuilt from a better track."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class PingTrack:
    """The pings of a flight and the vehicle's estimated poses; about 4 kB per ping.

    For each ping: its time; world_from_body and body_from_sonar, (4, 4); ranges_m, (beams,); deviation_m, (beams,),
    standard deviations of the echoes' positions, or None if unknown; points_sonar_m, (n, 3), the echoes of every
    BEAM_STEP-th beam, for matching; std_m, the filter's standard deviation of the horizontal position, per axis.
    """

    times_s: list[float] = field(default_factory=list)
    world_from_body: list[Array] = field(default_factory=list)
    body_from_sonar: list[Array] = field(default_factory=list)
    ranges_m: list[NDArray[np.float32]] = field(default_factory=list)
    deviation_m: list[NDArray[np.float32] | None] = field(default_factory=list)
    points_sonar_m: list[NDArray[np.float32]] = field(default_factory=list)
    std_m: list[float] = field(default_factory=list)

    def add(
        self,
        time_s: float,
        world_from_body: Array,
        body_from_sonar: Array,
        ranges_m: NDArray[np.float32],
        points_sonar_m: NDArray[np.float32],
        std_m: float,
        deviation_m: NDArray[np.float32] | None = None,
    ) -> None:
        """Add a ping. points_sonar_m: (beams, 3), not finite for beams without an echo."""
        self.times_s.append(time_s)
        self.world_from_body.append(np.array(world_from_body))
        self.body_from_sonar.append(np.array(body_from_sonar))
        self.ranges_m.append(np.array(ranges_m, np.float32))
        self.deviation_m.append(None if deviation_m is None else np.array(deviation_m, np.float32))
        some = np.asarray(points_sonar_m, np.float32)[::BEAM_STEP]
        self.points_sonar_m.append(some[np.isfinite(some).all(axis=1)])
        self.std_m.append(std_m)

    def __len__(self) -> int:
        """Return the number of pings."""
        return len(self.times_s)

    def points_world_m(self, ping: int) -> Array:
        """Return the echoes (n, 3) of a ping for matching, placed in the world by the estimated pose."""
        world_from_sonar = self.world_from_body[ping] @ self.body_from_sonar[ping]
        return np.asarray(self.points_sonar_m[ping] @ world_from_sonar[:3, :3].T + world_from_sonar[:3, 3])


BEAM_STEP = 4  # every fourth beam is stored as a point, for matching; all beams are stored as ranges, for the map
