"""Benchmark: a named task with its scenario, seeds, baseline and values, so that results of several labs compare."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from uwsim.flight.compare import Comparison, Target, plain_row
from uwsim.flight.paired import MORE_IS_BETTER
from uwsim.flight.request import EstimateKind, file_digest
from uwsim.scenario.fingerprint import build_fingerprint
from uwsim.scenario.load import load
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scoring.score_text import write_json

FOLDER, SUBMISSION = "benchmarks", "submission.json"
SEEDS, HELD_OUT = range(30), range(1000, 1030)
"""The seeds to develop with, and those that only a submission flies."""


class Benchmark(Model):
    """A benchmark.

    version: raised whenever results change their meaning. scenario: a packaged name. changes: replace values of the
    scenario; keys of `water` are added to its own. seeds_terrain: whether the seed also shapes the bed. baseline: name
    of a planner, or survey for the scenario's own. estimate, voxel_m, time_limit_s: see compare. target_m, last_s:
    place where the vehicle must be, for this long at the end. values: columns that count, the first of which ranks.
    """

    name: Name
    version: Annotated[int, InRange(1, 1000)]
    task: str = Field(min_length=1, max_length=300)
    scenario: str
    changes: dict[str, Any] = Field(default_factory=dict)
    seeds_terrain: bool = False
    baseline: Name
    estimate: EstimateKind = "filter"
    voxel_m: Annotated[float, InRange(0.02, 10, "m")]
    time_limit_s: Annotated[float, InRange(1, 1e5, "s")] | None = None
    target_m: Point3 | None = None
    last_s: Annotated[float, InRange(0.1, 1e5, "s")] = 10.0
    values: list[str] = Field(min_length=1)

    @model_validator(mode="after")
    def _ranks_by_known_values(self) -> Benchmark:
        for value in self.values:
            if value not in MORE_IS_BETTER:
                raise broken(f"must be among {', '.join(MORE_IS_BETTER)}", at=("values",), value=value)
        for part in ("water", *(["terrain"] if self.seeds_terrain else [])):
            if not isinstance(value := self.changes.get(part, {}), Mapping):
                raise broken("must be a mapping", at=("changes", part), value=value)
        return self

    @property
    def target(self) -> Target | None:
        """The place to be at the end, if there is one."""
        if self.target_m is None:
            return None
        x, y, z = (float(each) for each in self.target_m)
        return Target((x, y, z), self.last_s)

    def scenario_of(self, seed: int) -> Scenario:
        """Return the scenario with a seed. Raises ScenarioError if the changes do not fit."""
        data = {**(given := load(self.scenario).given()), **self.changes, "seed": seed}
        data["water"] = {**given["water"].given(), **self.changes.get("water", {})}
        if self.seeds_terrain:
            terrain = data["terrain"]
            data["terrain"] = {**(terrain if isinstance(terrain, dict) else terrain.given()), "seed": seed}
        return validated(Scenario, data)


def load_benchmark(name: str | Path) -> Benchmark:
    """Return a packaged benchmark, or that of a file. Raises ScenarioError."""
    return read_spec(Benchmark, name, FOLDER)


def write_submission(benchmark: Benchmark, found: Comparison, missions: dict[str, Path | None], folder: Path) -> Path:
    """Write submission.json, with what a table of several labs needs, and return its path. Raises OSError."""
    from importlib.metadata import version

    path = folder / SUBMISSION
    seeds = sorted({row.seed for row in found.rows})
    write_json(path, {
        "benchmark": benchmark.name,
        "version": benchmark.version,
        "held_out": set(seeds) <= set(HELD_OUT),
        "seeds": seeds,
        "uwsim": version("uwsim"),
        "build": build_fingerprint(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "missions": {name: file_digest(file) if file else "packaged" for name, file in missions.items()},
        "rows": [plain_row(row) for row in found.rows],
        "pairs": [plain_row(pair) for pair in found.pairs],
    })  # fmt: skip
    return path
