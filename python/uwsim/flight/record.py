"""The result of a flight."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim.flight.samples import Samples
from uwsim.mapping import OccupancyMap
from uwsim.missions.own_vehicle import Event
from uwsim.scoring.map_score import MapScore

if TYPE_CHECKING:
    from uwsim.flight.closed_flight import ClosedPath
    from uwsim.flight.map_growth import GrowthRow
    from uwsim.link.table import LinkRow

INTERRUPTED = "interrupted (Ctrl-C)"
DONE = "the mission is complete"


@dataclass(frozen=True, eq=False)
class FlightRecord:
    """A mission that was flown.

    scenario, seed, step_s: of the simulator; of a remote vehicle its URL and None. estimate: what its poses are of.
    result: what the mission returned; None if it did not end by itself. ended_because: a sentence. ended_early: whether
    something else than the mission or --time-limit ended it. error: of the mission. samples: by vehicle. occupancy: the
    map; pings_world_m: the sonars' estimated positions at each ping, by vehicle; score: of the map, None without one.
    link: what it carried, by topic. closed: by vehicle, the tracks with loops closed, which the map is made of then.
    map_growth: the map against the true surface while it was made.
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
    events: list[Event]
    samples: dict[str, Samples]
    result: Any = None
    error: Exception | None = None
    occupancy: OccupancyMap | None = None
    pings_world_m: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    echo_count: int = 0
    range_max_m: float = 0.0
    score: MapScore | None = None
    link: list[LinkRow] = field(default_factory=list)
    closed: dict[str, ClosedPath] = field(default_factory=dict)
    map_growth: tuple[GrowthRow, ...] = ()

    def __repr__(self) -> str:
        """Which mission, where, how long and why it ended."""
        return (
            f"<FlightRecord of {self.mission} in '{self.scenario}': {self.simulated_s:.1f} s simulated in "
            f"{self.wall_s:.1f} s, {len(self.events)} events; ended because {self.ended_because}>"
        )

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
        return self.ended_because == INTERRUPTED

    @property
    def collisions(self) -> int:
        """Collisions of all vehicles."""
        return sum(int(samples["collisions"][-1]) for samples in self.samples.values() if len(samples))

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second of wall time."""
        return self.simulated_s / self.wall_s if self.wall_s > 0.0 else 0.0

    @property
    def all_pings_world_m(self) -> NDArray[np.float64]:
        """(n, 3), of all vehicles, one after the other."""
        return np.concatenate([*self.pings_world_m.values(), np.empty((0, 3))])
