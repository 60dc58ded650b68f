"""The result of a survey apart from its map, whether it finished or was interrupted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from uwsim.scoring.survey_track import SurveyTrack
from uwsim.survey.wall_time import MAP_THREAD_STAGES

if TYPE_CHECKING:
    from uwsim.survey.ashore import Ashore

INTERRUPTED = "interrupted (Ctrl-C)"
FloatArray = NDArray[np.floating]
EstimateKind = Literal["truth", "filter"]
ESTIMATES: tuple[EstimateKind, ...] = ("truth", "filter")


@dataclass(frozen=True, eq=False)
class PingSample:
    """One ping, kept for the figure of the sonar's fan.

    ranges_m: (beams,), inf for no echo. angles_rad: (beams,), in the sonar's x-y plane, positive to port.
    world_from_sonar: (4, 4). points_world_m: (echoes, 3).
    """

    ranges_m: FloatArray
    angles_rad: FloatArray
    world_from_sonar: NDArray[np.float64]
    points_world_m: FloatArray


@dataclass(frozen=True, eq=False)
class SurveyRecord:
    """The request, the flight and the time it took.

    path_world_m: (n, 3), the sonar's position at each ping, in order. area_world_m: (k, 2), the polygon to survey.
    ping_interval_s: longer than requested where sound takes longer to the maximum range and back. sample_ping: None
    when the survey ended too early for one. stage_wall_s: wall seconds by stage, see wall_time.py. verified: whether
    the map equals stock OctoMap's byte for byte; None when it was not compared. outlier_filter: whether
    ranging.reject_outliers was in the chain. pings_with_warning: number of pings
    during which each of the panel's warnings was lit; warning_limits_m: the distances from which they are. coverage:
    share of the visible surface that is in the map, 0..1; None when the map was not scored.
    lanes_left_out: a sentence on the lanes that cannot be flown; None if there are none. estimate: whether mission and
    map went by the true pose or by the vehicle's own filter; path_world_m is the true path in both cases.
    position_error_m: (n,), how far the sonar was from where the map was told that it was, at each ping. ashore: what
    the station has of it, where there is a link.
    """

    scenario_name: str
    seed: int
    sonar_model: str
    step_s: float
    voxel_m: float
    threads: int
    stopped_because: str
    simulated_s: float
    wall_s: float
    ping_count: int
    echo_count: int
    collision_count: int
    path_world_m: NDArray[np.float64]
    area_world_m: NDArray[np.float64]
    range_max_m: float
    ping_interval_s: float
    ping_interval_requested_s: float
    sample_ping: PingSample | None = None
    stage_wall_s: dict[str, float] = field(default_factory=dict)
    ended_early: bool = False
    verified: bool | None = None
    outlier_filter: bool = False
    pings_with_warning: dict[str, int] = field(default_factory=dict)
    warning_limits_m: dict[str, float] = field(default_factory=dict)
    coverage: float | None = None
    lanes_left_out: str | None = None
    estimate: EstimateKind = "truth"
    position_error_m: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    ashore: Ashore | None = None

    def __repr__(self) -> str:
        """Where, how long, what was seen and why it ended."""
        coverage = "" if self.coverage is None else f", coverage {100 * self.coverage:.1f} %"
        return (
            f"<SurveyRecord of '{self.scenario_name}', seed {self.seed}: {self.simulated_s:.1f} s simulated in "
            f"{self.wall_s:.1f} s, {self.ping_count} pings{coverage}; ended because {self.stopped_because}>"
        )

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the survey."""
        return self.stopped_because == INTERRUPTED

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second of wall time; 0 before anything ran."""
        return self.simulated_s / self.wall_s if self.wall_s > 0.0 else 0.0

    @property
    def rest_wall_s(self) -> float:
        """Wall time of the flying thread that belongs to no stage. With several threads the map has its own."""
        flying = [s for stage, s in self.stage_wall_s.items() if stage not in MAP_THREAD_STAGES or self.threads == 1]
        return max(self.wall_s - sum(flying), 0.0)

    @property
    def track(self) -> SurveyTrack:
        """The part of the record that the score of the map depends on."""
        return SurveyTrack(self.path_world_m, self.area_world_m, self.range_max_m, self.scenario_name)

    @property
    def path_length_m(self) -> float:
        """Length of the line through the pings' positions."""
        return float(np.linalg.norm(np.diff(self.path_world_m, axis=0), axis=1).sum())
