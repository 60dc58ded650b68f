"""What is noted of each ping as a survey goes on."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.survey.record import PingSample
from uwsim.survey.true_surface import inside_polygon

PINGS_A_CANDIDATE = 10  # for the report's picture


@dataclass
class SurveyLog:
    """Where each ping was taken, how many echoes came back, and the most telling ping."""

    area_world_m: NDArray[np.float64]
    positions_world_m: list[NDArray[np.float64]] = field(default_factory=list)
    echo_count: int = 0
    richest: PingSample | None = None
    richest_score: float = -1.0

    def note(self, ping: _core.Ping, points_world_m: NDArray[np.float32]) -> None:
        """Keep the ping's place, count its echoes, and now and then see whether it makes a better picture."""
        position = ping.world_from_sonar[:3, 3].copy()  # a view would keep the whole ping
        self.positions_world_m.append(position)
        self.echo_count += len(points_world_m)
        if len(self.positions_world_m) % PINGS_A_CANDIDATE:
            return
        # The picture wants a full fan that also meets something other than the bed.
        things = len(np.unique(ping.labels[ping.valid]))
        score = 100.0 * things + float(ping.valid.mean())
        if score > self.richest_score and inside_polygon(position[None, :2], self.area_world_m)[0]:
            self.richest_score = score
            self.richest = PingSample(ping.ranges_m, ping.angles_rad, ping.world_from_sonar, points_world_m)

    def copy(self) -> SurveyLog:
        """As it is now; what was noted does not change."""
        return replace(self, positions_world_m=self.positions_world_m.copy())

    @property
    def path_world_m(self) -> NDArray[np.float64]:
        """(n, 3), where the sonar was at each ping."""
        return np.array(self.positions_world_m, np.float64).reshape(-1, 3)
