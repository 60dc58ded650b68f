"""The request for a flight, with every default resolved: enough to rebuild its simulator and maps."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import ConfigDict

from uwsim.flight.survey_area import with_survey
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.simulator.simulator import Simulator

EstimateKind = Literal["truth", "filter"]
ESTIMATES: tuple[EstimateKind, ...] = ("truth", "filter")
OF_SIMULATOR = ("seed", "sonar_model", "sonar_frequency_hz", "vehicle_model", "mission_time_s", "link")
"""Names of the arguments of the simulator."""


@dataclass(frozen=True)
class FlightRequest:
    """The arguments that determine a flight.

    mission: the path of its file, or `module:name`; if None, the scenario's survey. mission_digest: digest of the file.
    vehicles: by default the scenario's first, or all if the mission takes `vehicles`. vehicle_model: replaces the first
    vehicle's. link: a modem that replaces the scenario's. survey: values that replace those of the scenario's survey.
    carried: name endings of the channels that vehicles send over the link. time_limit_s: limit in simulated time; by
    default the battery life. voxel_m, engine, verify_map, outlier_filter, map_growth: options of the map, if one is
    built. sample_sensors: whether `samples` include the sensors' readings.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    mission: str | None = None
    function: str = "mission"
    mission_digest: str | None = None
    arguments: dict[str, Any] = field(default_factory=dict)
    scenario: str = "lake"
    seed: int | None = None
    sonar_model: int | str | None = None
    sonar_frequency_hz: float | None = None
    vehicle_model: str | None = None
    mission_time_s: float | None = None
    link: str | None = None
    survey: dict[str, Any] = field(default_factory=dict)
    carried: tuple[str, ...] | None = None
    vehicles: tuple[str, ...] = ()
    estimate: EstimateKind = "truth"
    map: bool = False
    voxel_m: float | None = None
    engine: MapEngine = "bricks"
    verify_map: bool = False
    outlier_filter: bool | None = None
    map_growth: bool = True
    sample_sensors: bool = True
    time_limit_s: float | None = None

    def new_simulator(self, threads: int | None = None) -> Simulator:
        """Return a new simulator for the flight. Raises ScenarioError or ValueError if the request is invalid."""
        scenario = with_survey(self.scenario, self.survey) if self.survey else self.scenario
        return Simulator(scenario, threads=threads, **{name: getattr(self, name) for name in OF_SIMULATOR})

    def new_reference(self) -> OccupancyMap | None:
        """Return an empty stock OctoMap for verification if requested, else None."""
        assert self.voxel_m is not None or not self.verify_map
        return OccupancyMap(resolution_m=self.voxel_m or 1.0, engine="octomap") if self.verify_map else None


def resolved_path(name: Any) -> Any:
    """Return the absolute path of a file; return anything else, such as a packaged scenario's name, unchanged."""
    if isinstance(name, str | Path):
        return str(Path(name).resolve()) if Path(name).is_file() else str(name)
    return name


def file_digest(path: Path) -> str:
    """Return a digest of a file's content. Raises OSError."""
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
