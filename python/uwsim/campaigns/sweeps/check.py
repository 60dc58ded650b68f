"""Checks a sweep before it is flown: every name it varies, and both ends of every range, one at a time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from uwsim.base.named import did_you_mean
from uwsim.campaigns.sweeps.design import Run
from uwsim.campaigns.sweeps.job import Job
from uwsim.campaigns.sweeps.spec import SweepSpec, beside
from uwsim.flight.flyable_lanes import required_survey
from uwsim.flight.mission_file import MissionError, load_mission, with_arguments
from uwsim.flight.pinging import require_sonar
from uwsim.flight.request import file_digest
from uwsim.scenario import ScenarioError
from uwsim.scenario.read.spec_file import SourceFile
from uwsim.scenario.variation import Level, extremes
from uwsim.simulator.simulator import Simulator

FILES = ("mission", "scenario")
MAX_TRIED = 200
"""The number of choices per name that are tried in advance; errors in the others appear in their runs."""


class Jobs:
    """Builds the jobs for the runs of a sweep."""

    def __init__(self, spec: SweepSpec, folder: Path) -> None:
        self._spec, self._folder = spec, folder
        self._digests: dict[str, str] = {}

    def of(self, run: Run) -> Job:
        """Return the job for a run. Raises MissionError if its mission file is missing."""
        return self.with_levels(run.levels, run.seed)

    def with_levels(self, levels: Mapping[str, Level], seed: int | None = None) -> Job:
        """Return the job for these levels."""
        spec = self._spec
        values = {name: beside(self._folder, level.value) for name, level in levels.items()}
        mission = values.pop("mission", None if spec.mission is None else str(spec.mission))
        arguments = {n.removeprefix("mission."): values.pop(n) for n in list(values) if n.startswith("mission.")}
        return Job(
            scenario=str(values.pop("scenario", spec.scenario)),
            seed=seed,
            values=values,
            mission=mission,
            mission_digest=None if mission is None else self._digest(str(mission)),
            arguments={**spec.arguments, **arguments},
            map=spec.map,
            voxel_m=spec.voxel_m,
            estimate=spec.estimate,
            time_limit_s=spec.time_limit_s,
            wall_limit_s=spec.wall_limit_s,
        )

    def _digest(self, mission: str) -> str:
        if mission not in self._digests:
            if not Path(mission).is_file():
                raise MissionError(f"mission = '{mission}': no such file in {self._folder}")
            self._digests[mission] = file_digest(Path(mission))
        return self._digests[mission]


def require_flyable(spec: SweepSpec, source: SourceFile, folder: Path) -> None:
    """Raise ScenarioError, with one line per mistake, if a choice or either end of a range is rejected.

    Each value is first tried alone, so that each mistake is reported once. A rejected value is tried again with the
    first values of all other names. One simulator is built, with all the first values.
    """
    jobs, mistakes = Jobs(spec, folder), list[str]()
    first = {name: extremes(variation)[0] for name, variation in spec.vary.items()}
    always = {name: level for name, level in first.items() if name in FILES}

    def refused(levels: Mapping[str, Level], *, whole: bool = False) -> list[str]:
        try:
            _require_job(jobs.with_levels(levels), whole=whole)
        except (ValueError, OSError) as error:
            return list(getattr(error, "mistakes", None) or [str(error)])
        return []

    if unvaried := refused(always):
        raise ScenarioError.of([source.file_prefix + mistake for mistake in unvaried])
    for name, variation in spec.vary.items():
        for level in extremes(variation)[:MAX_TRIED]:
            found = refused({**always, name: level})
            if found and refused({**first, name: level}):
                mistakes += [f"{source.line_prefix('vary', name)}vary: {mistake}" for mistake in found]
    if not mistakes:
        mistakes = [source.file_prefix + mistake for mistake in refused(first, whole=True)]
    if mistakes:
        raise ScenarioError.of(list(dict.fromkeys(mistakes)))


def require_metrics(spec: SweepSpec, source: SourceFile, run: int, metrics: Mapping[str, object]) -> bool:
    """Raise ScenarioError, with one line per mistake, if the sweep names a metric that a successful run does not have.

    metrics: the results of that run. Returns whether all names have been checked: a mission may have returned nothing
    this time, and several missions may return different values.
    """
    is_open = spec.flies_missions and ("mission" in spec.vary or metrics.get("result", 0) is None)
    named: list[tuple[tuple[str | int, ...], str, str]] = [(("require", one), "require", one) for one in spec.require]
    named += [(("show", k), "show", name) for k, name in enumerate(spec.show)]
    if spec.objective is not None:
        named.append((("objective", "metric"), "objective.metric", spec.objective.metric))
    unknown = [each for each in named if each[2] not in metrics and not (is_open and each[2].startswith("result."))]
    if unknown:
        mistakes = [
            f"{source.line_prefix(*keys)}{place} = {name}: run {run} has no such metric{did_you_mean(name, metrics)}"
            for keys, place, name in unknown
        ]
        raise ScenarioError.of([*mistakes, f"run {run} has {', '.join(metrics)}; correct the names and resume"])
    return not is_open


def _require_job(job: Job, *, whole: bool) -> None:
    scenario = job.varied_scenario()
    if job.mission is None:
        required_survey(scenario)
    else:
        with_arguments(load_mission(job.mission), job.arguments)
    if whole:
        Simulator(scenario, threads=1)
        if job.makes_map:
            require_sonar(scenario, scenario.vehicles[0].name)
