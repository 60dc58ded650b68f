"""The record of a flight, whether it was completed or interrupted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, Protocol

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.flight.coverage import LanesFlown, lanes_flown
from uwsim.flight.log import PingSample
from uwsim.flight.samples import Samples
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.mapping.map_filler import MAPPING, VERIFICATION, WAITING
from uwsim.missions.own_vehicle import Event
from uwsim.missions.run import R_co
from uwsim.scoring.map_score import MapScore
from uwsim.scoring.sounding_quality import SoundingQuality
from uwsim.scoring.survey_track import SurveyTrack
from uwsim.simulator.link_traffic import LinkRow

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from uwsim.flight.coverage import GrowthRow


PHYSICS, RAYS, CODEC, CONVERSION, SAMPLING, MISSION = "physics", "rays", "codec", "conversion", "samples", "mission"
STAGES = (PHYSICS, RAYS, CODEC, CONVERSION, SAMPLING, MISSION, MAPPING)
AUTOSAVE, RECORDING = "autosave", "recording"  # listed only when used, like VERIFICATION
MAP_THREAD_STAGES = (MAPPING, VERIFICATION, AUTOSAVE)  # run on the map's thread, if it has one

__all__ = [
    "AUTOSAVE", "CODEC", "CONVERSION", "MAPPING", "MAP_THREAD_STAGES", "MISSION", "PHYSICS", "RAYS", "RECORDING",
    "SAMPLING", "STAGES", "VERIFICATION", "WAITING",
]  # fmt: skip


DONE = "the mission is complete"
BATTERY_EMPTY = "the battery is used up"  # missions that check the battery themselves use the same text
INTERRUPTED = "interrupted (Ctrl-C)"


class Ashore(Protocol):
    """The station's end of a link: what arrived of a mapping flight; see uwsim.link.flight."""

    @property
    def ping_count(self) -> int:
        """Number of pings that have arrived."""

    def table(self) -> list[LinkRow]:
        """Return the numbers of messages sent, delivered, lost and late, by topic."""

    def made_map(self, resolution_m: float, engine: MapEngine) -> OccupancyMap:
        """Return a map built from the pings that have arrived."""


@dataclass(frozen=True, eq=False)
class FlightRecord(Generic[R_co]):
    """The record of a flown mission.

    scenario, seed, step_s: as in the simulator; for remote vehicles, scenario is the URL and the others are None.
    estimate: source of the poses used. result: the mission's return value, or a tuple of them if each of several
    vehicles flies it; None if the mission did not end by itself.
    ended_because: the reason, as a clause. ended_early: whether the flight was ended by anything but the mission itself
    or --time-limit. error: the exception that the mission raised, if any. samples: samples by vehicle. stage_wall_s:
    wall time of each stage in seconds. link: the link's traffic by topic. ashore: the station's data, if there is a
    link.

    If a map was built: occupancy: the map. pings_world_m: by vehicle, the sonar position used for the map at each ping;
    true_pings_world_m: the true positions. area_world_m: (k, 2), the polygon in which the map is scored. score: None
    before scoring. verified: whether the map equals stock OctoMap's byte for byte; None if not compared.
    ping_interval_s: longer than requested if sound takes longer to the maximum range and back. pings_with_warning:
    number of pings during which each of the panel's warnings was on; warning_limits_m: the distances at which they come
    on. sample_ping: one ping, for the report. map_growth: measurements of the map while it was being built. planned:
    whether the mission flew the plan of the scenario's survey; lanes_left_out: a sentence about its lanes that could
    not be flown. soundings: of a raw survey, if one was written. budgets_m: by vehicle that was flown by its filter,
    the standard deviations (3,) of its position at the end, by their source.
    """

    mission: str
    scenario: str
    seed: int | None
    estimate: str
    step_s: float | None
    ended_because: str
    ended_early: bool
    simulated_s: float
    wall_s: float
    events: list[Event] = field(default_factory=list)
    samples: dict[str, Samples] = field(default_factory=dict)
    budgets_m: dict[str, dict[str, Floats]] = field(default_factory=dict)
    result: R_co = None  # type: ignore[assignment]  # the type of a mission that has ended by itself
    error: Exception | None = None
    sonar_model: str | None = None
    threads: int = 1
    stage_wall_s: dict[str, float] = field(default_factory=dict)
    occupancy: OccupancyMap | None = None
    pings_world_m: dict[str, Floats] = field(default_factory=dict)
    true_pings_world_m: dict[str, Floats] = field(default_factory=dict)
    echo_count: int = 0
    range_max_m: float = 0.0
    voxel_m: float = 0.0
    free_voxels: int = 0
    outlier_filter: bool = False
    ping_interval_s: float = 0.0
    ping_interval_requested_s: float = 0.0
    pings_with_warning: dict[str, int] = field(default_factory=dict)
    warning_limits_m: dict[str, float] = field(default_factory=dict)
    sample_ping: PingSample | None = None
    area_world_m: Floats | None = None
    score: MapScore | None = None
    verified: bool | None = None
    link: list[LinkRow] = field(default_factory=list)
    ashore: Ashore | None = None
    ashore_score: MapScore | None = None
    map_growth: tuple[GrowthRow, ...] = ()
    lanes_left_out: str | None = None
    planned: bool = False
    soundings: SoundingQuality | None = None

    def __repr__(self) -> str:
        """Return the mission, the scenario, the duration and the reason the flight ended."""
        pings = f", {self.ping_count} pings" if self.ping_count else ""
        coverage = "" if self.coverage is None else f", coverage {100 * self.coverage:.1f} %"
        return (
            f"<FlightRecord of {self.mission} in '{self.scenario}': {self.simulated_s:.1f} s simulated in "
            f"{self.wall_s:.1f} s, {len(self.events)} events{pings}{coverage}; ended because {self.ended_because}>"
        )

    def plot(self) -> Figure:
        """Return a matplotlib Figure of the first vehicle's true path from above, coloured by height."""
        return next(iter(self.samples.values())).plot()

    def _repr_png_(self) -> bytes | None:
        return next(iter(self.samples.values()))._repr_png_() if self.samples else None

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the flight."""
        return self.ended_because == INTERRUPTED

    @property
    def collisions(self) -> int:
        """The total number of collisions of all vehicles."""
        return sum(int(samples["collisions"][-1]) for samples in self.samples.values() if len(samples))

    @property
    def lanes(self) -> LanesFlown | None:
        """The lanes planned and flown; None if no mission flew lanes."""
        return lanes_flown(self.events)

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second of wall time; 0 before anything has run."""
        return self.simulated_s / self.wall_s if self.wall_s > 0.0 else 0.0

    @property
    def rest_wall_s(self) -> float:
        """Wall time that the flying thread spent outside all stages.

        With several threads, the map stages run on another thread.
        """
        flying = [s for stage, s in self.stage_wall_s.items() if stage not in MAP_THREAD_STAGES or self.threads == 1]
        return max(self.wall_s - sum(flying), 0.0)

    @property
    def all_pings_world_m(self) -> Floats:
        """The sonar positions (n, 3) used for the map, vehicle by vehicle."""
        return np.concatenate([*self.pings_world_m.values(), np.empty((0, 3))])

    @property
    def path_world_m(self) -> Floats:
        """The true sonar positions (n, 3) at the pings, vehicle by vehicle, or the estimated ones if unknown."""
        return np.concatenate([*(self.true_pings_world_m or self.pings_world_m).values(), np.empty((0, 3))])

    @property
    def position_error_m(self) -> Floats:
        """Distance (n,) between the true sonar position and the one used for the map, at each ping."""
        return np.asarray(np.linalg.norm(self.all_pings_world_m - self.path_world_m, axis=1), np.float64)

    @property
    def ping_count(self) -> int:
        """Number of pings in the map."""
        return sum(map(len, self.pings_world_m.values()))

    @property
    def path_length_m(self) -> float:
        """Total length of the polylines through the true ping positions of all vehicles."""
        paths = (self.true_pings_world_m or self.pings_world_m).values()
        return sum(float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in paths)

    @property
    def coverage(self) -> float | None:
        """Share of the visible surface that is in the map, 0..1; None if the map was not scored."""
        return None if self.score is None else self.score.coverage

    @property
    def track(self) -> SurveyTrack | None:
        """The part of the record on which the map's score depends; None without a scored area."""
        if self.area_world_m is None:
            return None
        return SurveyTrack(self.path_world_m, self.area_world_m, self.range_max_m, self.scenario)
