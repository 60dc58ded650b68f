"""A log of a survey's pings: positions, echoes, the panel's warnings, and one sample ping for the report."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scoring.polygon import inside_polygon
from uwsim.survey.record import PingSample

PINGS_PER_CANDIDATE = 50  # one ping in so many is a candidate for the sample
PANEL_WARNINGS = ("range", "proximity", "collision")
"""The warnings of the vehicle's panel, `range_warning` and so on of its telemetry."""
_LIT = attrgetter(*(f"{name}_warning" for name in PANEL_WARNINGS))


@dataclass
class PingLog:
    """The position of each ping, the number of echoes, and the ping with the most distinct labels.

    pings_with_warning: the number of pings during which each of PANEL_WARNINGS was lit. position_error_m: how far the
    sonar was from where the map was told that it was.
    """

    area_world_m: NDArray[np.float64]
    positions_world_m: list[list[float]] = field(default_factory=list)
    position_error_m: list[float] = field(default_factory=list)
    echo_count: int = 0
    sample: PingSample | None = None
    sample_score: float = -1.0
    pings_with_warning: dict[str, int] = field(default_factory=lambda: dict.fromkeys(PANEL_WARNINGS, 0))

    def add(
        self,
        ping: _core.Ping,
        points_world_m: NDArray[np.float32],
        panel: _core.Telemetry,
        mapped_from_m: NDArray[np.float64] | None = None,
    ) -> None:
        """Log a ping's position, echoes and warnings; every few pings, keep it as the sample if it is better.

        mapped_from_m: (3,) where the map was told that the sonar was, if not where it was.
        """
        if True in (lit := _LIT(panel)):
            for name, is_lit in zip(PANEL_WARNINGS, lit, strict=True):
                self.pings_with_warning[name] += is_lit
        position = ping.world_from_sonar[:3, 3].tolist()
        self.positions_world_m.append(position)
        self.position_error_m.append(0.0 if mapped_from_m is None else math.dist(position, mapped_from_m))
        self.echo_count += len(points_world_m)
        if len(self.positions_world_m) % PINGS_PER_CANDIDATE == 0:
            self._consider(ping, points_world_m, position)

    def _consider(self, ping: _core.Ping, points_world_m: NDArray[np.float32], position: list[float]) -> None:
        """Keep a ping as the sample if it is better."""
        # The best sample is a full fan that hits solids as well as the bed.
        labels = ping.labels[ping.valid]
        score = 100.0 * np.count_nonzero(np.bincount(labels)) + len(labels) / len(ping.labels)
        if score > self.sample_score and inside_polygon(np.array([position[:2]]), self.area_world_m)[0]:
            self.sample_score = score
            self.sample = PingSample(ping.ranges_m, ping.angles_rad, ping.world_from_sonar, points_world_m)

    def copy(self) -> PingLog:
        """Return a copy that later pings do not change."""
        return replace(
            self,
            positions_world_m=self.positions_world_m.copy(),
            position_error_m=self.position_error_m.copy(),
            pings_with_warning=self.pings_with_warning.copy(),
        )

    @property
    def path_world_m(self) -> NDArray[np.float64]:
        """(n, 3), the sonar's position at each ping."""
        return np.array(self.positions_world_m, np.float64).reshape(-1, 3)
