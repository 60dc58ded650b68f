"""The schema of a sweep YAML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.base.texts.yaml_document import YamlDocument
from uwsim.flight.request import EstimateKind
from uwsim.scenario.read.spec_file import SourceFile, read_yaml
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import AssetFile, InRange, Model, Name, broken
from uwsim.scenario.variation import Bound, Variation

Method = Literal["grid", "random", "latin_hypercube", "sobol", "saltelli"]
MAX_RUNS = 1_000_000
SeedNumber = Annotated[int, InRange(0, 2**63 - 1)]


def _scenario(value: object, info: ValidationInfo) -> object:
    """Return the absolute path if the value names a file next to the sweep file, or else the value unchanged."""
    return beside((info.context or {}).get("folder", Path()), value)


def beside(folder: Path, value: Any) -> Any:
    """Return a value with each string that names a file in the folder replaced by the file's absolute path."""
    if isinstance(value, str) and value and len(value) < 1000 and "\n" not in value and (folder / value).is_file():
        return str((folder / value).resolve())
    if isinstance(value, Mapping):
        return {key: beside(folder, item) for key, item in value.items()}
    return [beside(folder, item) for item in value] if isinstance(value, list | tuple) else value


class Seeds(Model):
    """Consecutive seeds.

    first: the first seed. count: the number of seeds with which each sample is flown; without it, sample k is flown
    once, with seed first + k.
    """

    first: SeedNumber = 0
    count: Annotated[int, InRange(1, MAX_RUNS)] | None = None


class Objective(Model):
    """The metric that distinguishes good runs from bad ones.

    metric: a column of the table, such as coverage, or result.NAME for a value that the mission returns. best: whether
    high or low is good.
    """

    metric: str
    best: Literal["high", "low"]


class Limits(Model):
    """Limits on a metric in every run; if one is outside, `uwsim sweep` ends with exit code 1.

    low: the smallest value allowed. high: the largest value allowed.
    """

    low: Bound | None = None
    high: Bound | None = None

    @model_validator(mode="after")
    def _limits_something(self) -> Limits:
        if self.low is None and self.high is None:
            raise broken("must have low, high or both")
        return self


class SweepSpec(Model):
    """A sweep: the flights and the values that vary.

    scenario: the name of a packaged scenario, or a file. mission: a Python file, as for `uwsim run`; without it, the
    scenario's survey is flown. arguments: values for the mission's other parameters. vary: variations by name; a name
    is a parameter (as listed by `uwsim scenario parameters`), a key of the scenario's file such as survey.altitude_m,
    faults or faults[0].at_s, `mission` or `scenario` for several files, or mission.NAME for a parameter of the mission.

    method: how samples are chosen: all combinations (grid), at random, spread evenly (latin_hypercube, sobol), or as
    Sobol' indices require (saltelli). samples: the number of samples; saltelli flies this many times the number of
    variations plus two. Each sample is flown with all seeds. seed: the seed for choosing samples. seeds: the seeds of
    the simulations; by default the scenario's seed.

    map: whether a mission builds a map, which is scored; surveys always do. voxel_m: overrides the scenario's.
    estimate: the pose by which vehicles steer, the truth or their own filter's estimate. time_limit_s: limit on a
    mission's simulated time. wall_limit_s: limit on the wall time of a run, after which it counts as failed. retries:
    how often a run is repeated if its process died. objective: defines good runs. require: limits on metrics, by
    column, for every run. show: the columns that the report draws; by default the objective and other metrics that
    vary. worst: the number of worst runs that are flown again, each with a recording and a report.
    """

    name: Name | None = None
    description: str = ""
    scenario: Annotated[str, BeforeValidator(_scenario)] = "lake"
    mission: AssetFile | None = None
    arguments: dict[str, Any] = Field({})
    vary: Annotated[dict[str, Variation], Field(max_length=200)] = Field({})
    method: Method = "grid"
    samples: Annotated[int, InRange(1, MAX_RUNS)] | None = None
    seed: SeedNumber = 0
    seeds: tuple[SeedNumber, ...] | Seeds | None = None
    map: bool = False
    voxel_m: Annotated[float, InRange(0.02, 10, "m")] | None = None
    estimate: EstimateKind = "truth"
    time_limit_s: Annotated[float, InRange(0.1, 1e6, "s")] | None = None
    wall_limit_s: Annotated[float, InRange(0.1, 1e6, "s")] | None = None
    retries: Annotated[int, InRange(0, 100)] = 2
    objective: Objective | None = None
    require: dict[str, Limits] = Field({})
    show: tuple[str, ...] = ()
    worst: Annotated[int, InRange(0, 100)] = 3

    @property
    def flies_missions(self) -> bool:
        """Whether missions are flown instead of surveys."""
        return self.mission is not None or "mission" in self.vary

    @model_validator(mode="after")
    def _has_a_count(self) -> SweepSpec:
        if self.method == "grid":
            if self.samples is not None:
                raise broken("has no effect on a grid, which contains all combinations", at=("samples",))
            for name, variation in self.vary.items():
                if variation.choices is None and variation.steps is None:
                    raise broken("must be given on a grid", at=("vary", name, "steps"))
            return self
        if self.samples is None:
            raise broken(f"must be given for `method: {self.method}`", at=("samples",))
        if self.method in ("sobol", "saltelli") and self.samples & (self.samples - 1):
            rule = "must be a power of two, for which these points are balanced"
            raise broken(rule, at=("samples",), value=self.samples)
        if not self.vary:
            raise broken(f"must not be empty for `method:  {self.method}`", at=("vary",))
        for name, variation in self.vary.items():
            if variation.steps is not None:
                raise broken("is for `method: grid`", at=("vary", name, "steps"), value=variation.steps)
        return self

    @model_validator(mode="after")
    def _has_no_ineffective_keys(self) -> SweepSpec:
        if not self.flies_missions:
            for key in ("map", "time_limit_s", "arguments"):
                if key in self.model_fields_set:
                    raise broken("is for a mission, not for a survey", at=(key,))
            if any(name.startswith("mission.") for name in self.vary):
                raise broken("there is no mission", at=("vary", next(n for n in self.vary if n.startswith("mission."))))
        elif self.voxel_m is not None and not self.map:
            raise broken("has no effect without `map: true`", at=("voxel_m",), value=self.voxel_m, unit="m")
        for key in ("mission", "scenario"):
            if key in self.vary and key in self.model_fields_set:
                raise broken("is varied: leave it out here", at=(key,))
            if key in self.vary and self.vary[key].choices is None:
                raise broken("must have choices: files or names", at=("vary", key))
        for name in self.arguments:
            if f"mission.{name}" in self.vary:
                raise broken("is varied: leave it out here", at=("arguments", name))
        if self.seeds == ():
            raise broken("must have at least one", at=("seeds",))
        return self


def read_sweep(source: str | Path | Mapping[str, Any]) -> tuple[SweepSpec, SourceFile, Path]:
    """Read a sweep from a file or from values; return it with its source and folder.

    Raises ScenarioError, with one line per mistake.
    """
    if isinstance(source, Mapping):
        return validated(SweepSpec, dict(source)), SourceFile(), Path.cwd()
    path = Path(source)
    document: YamlDocument = read_yaml(path, str(source))
    folder = path.resolve().parent
    return validated(SweepSpec, document.values, document, folder), SourceFile(document), folder
