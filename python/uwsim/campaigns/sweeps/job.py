"""One run of a sweep, flown by a worker: the scenario with the values of the run, the flight and its results."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from uwsim.campaigns.sweeps.vary import varied
from uwsim.campaigns.sweeps.wall_limit import WallLimitError, wall_limit
from uwsim.campaigns.workers.tidy import tidy_now_and_then
from uwsim.flight.fly import fly
from uwsim.flight.flyable_lanes import SurveyAreaWarning
from uwsim.flight.mission_file import MissionError
from uwsim.flight.pinging import SURVEYED
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import EstimateKind, file_digest
from uwsim.flight.results import scored
from uwsim.flight.summary import flight_values
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.simulator.simulator import Simulator

OF_THE_WALL = ("wall_s", "stage_wall_s", "threads", "seed", "scenario")
"""Values of a flight that depend on the wall clock, or that have another column in the table."""
MAX_LIST = 16
"""Longer lists among a flight's values are left out of the table."""


@dataclass(frozen=True)
class Job:
    """A run to be flown by a worker. values: keyed by parameter or scenario key. mission: a file; None for a survey."""

    scenario: str
    seed: int | None
    values: dict[str, Any]
    mission: str | None = None
    mission_digest: str | None = None
    arguments: dict[str, Any] = field(default_factory=dict)
    map: bool = False
    voxel_m: float | None = None
    estimate: EstimateKind = "truth"
    time_limit_s: float | None = None
    wall_limit_s: float | None = None

    def varied_scenario(self) -> Scenario:
        """Return the run's scenario. Raises ScenarioError."""
        return varied(loaded(self.scenario), self.values).with_changes(seed=self.seed)

    @property
    def makes_map(self) -> bool:
        """Whether a map is built; always true for a survey."""
        return self.map or self.mission is None

    def flight(self) -> dict[str, Any]:
        """Return the arguments of `fly` for this run; a survey does not measure the growth of its map."""
        is_survey = self.mission is None
        return {
            "arguments": self.arguments, "map": self.makes_map, "map_growth": not is_survey,
            "voxel_m": self.voxel_m, "estimate": self.estimate, "time_limit_s": self.time_limit_s,
            "carried": SURVEYED if is_survey else None,
        }  # fmt: skip

    def fly(self, sim: Simulator) -> dict[str, Any]:
        """Fly and score the run; return its values, including those of the map, as the metrics of its result."""
        if self.mission is not None and not _is_same_file(Path(self.mission), self.mission_digest):
            raise MissionError(f"mission '{self.mission}': is missing here, or has changed since the sweep was started")
        flown = fly(self.mission, sim, report="none", autosave_s=0.0, **self.flight())
        if flown.interrupted:
            raise KeyboardInterrupt  # the flight caught the error, but half a run is not a result
        return {"metrics": flat(run_values(scored(flown, sim)))}


@lru_cache(maxsize=8)  # a worker flies the same few scenarios for hours
def loaded(scenario: str) -> Scenario:
    """Return a scenario by name or path."""
    return load(scenario)


def fly_job(job: Job) -> dict[str, Any]:
    """Fly a run; return what Job.fly returns, its provenance and the error, if any, that ended it.

    A mistake in the scenario or mission becomes an error in the result. Raises OSError and MemoryError, which may be
    transient.
    """
    begun_s, begun_cpu_s = time.perf_counter(), time.process_time()
    result: dict[str, Any] = {"metrics": {}, "error": None, "flight_wall_s": None}
    try:
        with wall_limit(job.wall_limit_s), warnings.catch_warnings():
            warnings.simplefilter("ignore", SurveyAreaWarning)  # the values contain lanes_left_out
            _fly(job, result)
    except (OSError, MemoryError):
        raise
    except (Exception, WallLimitError) as error:
        kind = "" if isinstance(error, ScenarioError | MissionError | WallLimitError) else f"{type(error).__name__}: "
        result["error"] = kind + " ".join(str(error).split())
    tidy_now_and_then(time.perf_counter() - begun_s)
    return {
        **result, "run_wall_s": time.perf_counter() - begun_s, "run_cpu_s": time.process_time() - begun_cpu_s
    }  # fmt: skip


def _fly(job: Job, result: dict[str, Any]) -> None:
    sim = Simulator(job.varied_scenario(), threads=1)
    result |= {"seed": sim.seed, "scenario_digest": scenario_fingerprint(sim.scenario), "build": build_fingerprint()}
    begun_s = time.perf_counter()
    try:
        result |= job.fly(sim)
    finally:
        result["flight_wall_s"] = time.perf_counter() - begun_s


def run_values(flown: FlightRecord) -> dict[str, Any]:
    """Return the values of a flight, with those of its map beside the others, and its result."""
    values = flight_values(flown)
    score = values.pop("map", {})
    if values["lanes"] is not None:
        del values["lanes"]["each"]  # its lanes would be columns
    return {**values, **score, "result": flown.result}


def _is_same_file(path: Path, digest: str | None) -> bool:
    return path.is_file() and file_digest(path) == digest


def flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Flatten nested values into dotted names, keeping only numbers, text, booleans and None."""
    found: dict[str, Any] = {}
    for name, value in values.items():
        if name not in OF_THE_WALL:
            _flatten(name, value, found)
    return found


def _flatten(name: str, value: Any, found: dict[str, Any]) -> None:
    if isinstance(value, Mapping):
        for key, item in value.items():
            _flatten(f"{name}.{key}", item, found)
    elif isinstance(value, list | tuple):
        for k, item in enumerate(value if len(value) <= MAX_LIST else ()):
            _flatten(f"{name}.{k}", item, found)
    elif hasattr(value, "item") and getattr(value, "ndim", 1) == 0:  # a NumPy scalar
        _flatten(name, value.item(), found)
    elif isinstance(value, float):
        found[name] = value if math.isfinite(value) else None
    elif value is None or isinstance(value, bool | int | str):
        found[name] = value
