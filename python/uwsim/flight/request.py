"""A flight as requested: enough to fly it again."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import ConfigDict

from uwsim.simulator import Simulator

EstimateKind = Literal["truth", "filter"]
ESTIMATES: tuple[EstimateKind, ...] = ("truth", "filter")


@dataclass(frozen=True)
class FlightRequest:
    """The arguments that determine a flight.

    mission: the path of its file; mission_digest: of the file's content. vehicles: by default the scenario's first, or
    all if the mission flies `vehicles`. link: a modem, instead of the scenario's. time_limit_s: simulated time, by
    default the scenario's mission time.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    mission: str
    function: str
    mission_digest: str
    arguments: dict[str, Any] = field(default_factory=dict)
    scenario: str = "lake"
    seed: int | None = None
    sonar_model: int | str | None = None
    mission_time_s: float | None = None
    link: str | None = None
    vehicles: tuple[str, ...] = ()
    estimate: EstimateKind = "truth"
    map: bool = False
    voxel_m: float | None = None
    time_limit_s: float | None = None

    def new_simulator(self, threads: int | None = None) -> Simulator:
        """Return the simulator at its start. Raises ScenarioError, ValueError."""
        return Simulator(
            self.scenario,
            seed=self.seed,
            sonar_model=self.sonar_model,
            mission_time_s=self.mission_time_s,
            link=self.link,
            threads=threads,
        )

    def require_same_file(self) -> None:
        """Raise ValueError if the mission's file is not what it was."""
        path = Path(self.mission)
        if not path.is_file() or file_digest(path) != self.mission_digest:
            raise ValueError(f"--resume: '{path}' is missing or has changed since: the flight cannot be repeated")


def file_digest(path: Path) -> str:
    """Return a digest of a file's content. Raises OSError."""
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
