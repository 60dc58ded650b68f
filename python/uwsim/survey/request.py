"""A survey as requested, with every default resolved: enough to build its simulator and its maps again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ConfigDict

from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.simulator import Simulator
from uwsim.survey.record import EstimateKind


@dataclass(frozen=True)
class SurveyRequest:
    """The arguments that determine a survey's map. scenario: a packaged scenario's name or an absolute path.

    mission: `module:name` of one's own; None: the lawn-mower.
    """

    scenario: str
    seed: int
    sonar_model: int | str | None
    sonar_frequency_khz: float | None
    mission_time_s: float | None
    voxel_m: float
    engine: MapEngine
    verify_map: bool
    outlier_filter: bool | None = None
    estimate: EstimateKind = "truth"
    mission: str | None = None
    link: str | None = None

    __pydantic_config__ = ConfigDict(extra="forbid")

    def new_simulator(self, threads: int | None = None) -> Simulator:
        """Return the simulator at its start. Raises ScenarioError or ValueError."""
        return Simulator(
            self.scenario,
            seed=self.seed,
            sonar_model=self.sonar_model,
            sonar_frequency_khz=self.sonar_frequency_khz,
            mission_time_s=self.mission_time_s,
            link=self.link,
            threads=threads,
        )

    def new_map(self, memory_limit_mb: float | None = None) -> OccupancyMap:
        """Return an empty map. memory_limit_mb: see OccupancyMap. Raises ValueError."""
        return OccupancyMap(resolution_m=self.voxel_m, engine=self.engine, memory_limit_mb=memory_limit_mb)

    def new_reference(self) -> OccupancyMap | None:
        """Return an empty stock OctoMap map if the map is to be verified against one, else None."""
        return OccupancyMap(resolution_m=self.voxel_m, engine="octomap") if self.verify_map else None

    def require_same(self, arguments: dict[str, Any]) -> None:
        """Raise ValueError if an argument that is not None differs from this request."""
        for name, value in arguments.items():
            requested = resolved_path(value) if name in ("scenario", "sonar_model", "link") else value
            begun_with = getattr(self, name)
            if requested is not None and requested != begun_with:
                raise ValueError(f"--resume: {name} = {requested}: the survey was begun with {begun_with}")


def resolved_path(name: Any) -> Any:
    """Return the absolute path of a file; anything else, such as a packaged scenario's name, as it is."""
    if isinstance(name, str | Path):
        return str(Path(name).resolve()) if Path(name).is_file() else str(name)
    return name
