"""A log of a vehicle's pings: positions, echoes, panel warnings, and a sample ping for the report."""

from __future__ import annotations

from dataclasses import dataclass, field
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scoring.polygon import inside_polygon

PINGS_PER_CANDIDATE = 50  # one ping in 50 is a candidate for the sample
PANEL_WARNINGS = ("range", "proximity", "collision")
"""The warnings on the vehicle's panel, fields `range_warning` and so on of its telemetry."""
lit = attrgetter(*(f"{name}_warning" for name in PANEL_WARNINGS))
"""Returns whether each of PANEL_WARNINGS is lit on a panel."""
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PingSample:
    """A ping stored for the report's picture of the sonar fan.

    ranges_m: (beams,), inf if there is no echo. angles_rad: (beams,), in the sonar's x-y plane, positive to port.
    world_from_sonar: (4, 4). points_world_m: (echoes, 3).
    """

    ranges_m: NDArray[np.floating]
    angles_rad: NDArray[np.floating]
    world_from_sonar: Array
    points_world_m: NDArray[np.floating]


@dataclass
class PingLog:
    """The position at each ping, the number of echoes, and a sample: the ping with the most distinct labels.

    area_world_m: polygon in which the sample must have been taken; None: anywhere. positions_m: true sonar positions.
    mapped_m: sonar positions used for the map. pings_with_warning: the number of pings during which each of
    PANEL_WARNINGS was on.
    """

    area_world_m: Array | None = None
    positions_m: list[list[float]] = field(default_factory=list)
    mapped_m: list[list[float]] = field(default_factory=list)
    echo_count: int = 0
    sample: PingSample | None = None
    sample_score: float = -1.0
    pings_with_warning: dict[str, int] = field(default_factory=lambda: dict.fromkeys(PANEL_WARNINGS, 0))

    def add(
        self,
        ping: _core.Ping,
        points_world_m: NDArray[np.float32],
        panel: _core.Telemetry,
        world_from_sonar: Array,
        mapped_from_m: Array | None = None,
    ) -> None:
        """Log the position, echoes and warnings of a ping; one ping in PINGS_PER_CANDIDATE may replace the sample.

        world_from_sonar: the pose of the sonar. mapped_from_m: the sonar position (3,) used for the map, if it differs
        from the true one.
        """
        if True in (are_lit := lit(panel)):
            for name, is_lit in zip(PANEL_WARNINGS, are_lit, strict=True):
                self.pings_with_warning[name] += is_lit
        position = world_from_sonar[:3, 3].tolist()
        self.positions_m.append(position)
        self.mapped_m.append(position if mapped_from_m is None else mapped_from_m.tolist())
        self.echo_count += len(points_world_m)
        if len(self.positions_m) % PINGS_PER_CANDIDATE == 0:
            self._consider(ping, points_world_m, position)

    def _consider(self, ping: _core.Ping, points_world_m: NDArray[np.float32], position: list[float]) -> None:
        """Store a ping as the sample if it is better than the current one."""
        # The best sample is a full fan that hits solids as well as the bed.
        labels = ping.labels[ping.valid]
        score = 100.0 * np.count_nonzero(np.bincount(labels)) + len(labels) / len(ping.labels)
        if score > self.sample_score and self._is_in_area(position):
            self.sample_score = score
            self.sample = PingSample(ping.ranges_m, ping.angles_rad, ping.world_from_sonar, points_world_m)

    def _is_in_area(self, position: list[float]) -> bool:
        area_m = self.area_world_m
        return area_m is None or bool(inside_polygon(np.array([position[:2]]), area_m)[0])

    @property
    def path_world_m(self) -> Array:
        """The true sonar position at each ping, (n, 3)."""
        return np.array(self.positions_m, np.float64).reshape(-1, 3)

    @property
    def mapped_path_m(self) -> Array:
        """The sonar position used for the map at each ping, (n, 3)."""
        return np.array(self.mapped_m, np.float64).reshape(-1, 3)
