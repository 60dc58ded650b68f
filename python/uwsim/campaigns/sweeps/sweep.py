"""run_sweep: flies all runs of a sweep on workers, and writes the table and report; `uwsim sweep` calls it."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from uwsim.base.folder_lock import alone_in
from uwsim.campaigns.sweeps.again import WORST, fly_run_again
from uwsim.campaigns.sweeps.check import FILES, Jobs, require_flyable, require_metrics
from uwsim.campaigns.sweeps.design import Run, runs_of
from uwsim.campaigns.sweeps.job import fly_job
from uwsim.campaigns.sweeps.rows import Rows
from uwsim.campaigns.sweeps.spec import SweepSpec, read_sweep
from uwsim.campaigns.sweeps.table import TABLE, write_table
from uwsim.campaigns.workers import Campaign, Finished, Ledger, RetriedOptions
from uwsim.campaigns.workers.work import Show
from uwsim.flight.folder import made_folder
from uwsim.scenario import load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.scenario.read.spec_file import SourceFile
from uwsim.scenario.variation import choices

REPORT = "report.html"

logger = logging.getLogger("uwsim.campaigns")


@dataclass(frozen=True, eq=False)
class Sweep:
    """A sweep, complete or in progress.

    rows: the table, with one row per finished run. out: the folder. runs: all runs, including those not yet flown.
    """

    spec: SweepSpec
    rows: Rows
    out: Path
    runs: list[Run] = field(repr=False)

    @property
    def interrupted(self) -> bool:
        """Whether runs are missing; `resume=True` flies them."""
        return len(self.rows) < len(self.runs)

    @property
    def failed(self) -> int:
        """The number of runs that ended with an error."""
        return len(self.rows.failed)

    @property
    def ended_early(self) -> int:
        """The number of runs that did not fail, but were ended by anything but their mission or time limit."""
        return len(self.rows.ended_early)

    @property
    def without_objective(self) -> int:
        """The number of runs that did not fail, but have no value of the sweep's objective."""
        return 0 if self.spec.objective is None else self.rows.without(self.spec.objective.metric)

    @property
    def missed(self) -> dict[str, int]:
        """The number of runs that are outside each limit in the sweep's `require`."""
        return self.rows.missed(self.spec.require)


def run_sweep(
    source: str | Path | Mapping[str, Any],
    out: str | Path,
    *,
    report: bool = True,
    **options: Any,
) -> Sweep:
    """Fly all runs of a sweep; write `out`/runs.parquet and, if requested, report.html, and repeat the worst runs.

    source: a YAML file or its values. options: those of uwsim.campaigns.workers.Campaign. workers: number of processes
    on this machine (default: one per core); 0 flies in this process. scheduler: the address of a Dask cluster to use
    instead. resume: fly the runs that are missing in `out`, which must have been begun with the same sweep and build.
    retry_failed: also repeat failed runs. A failed run becomes a row with its error. A metric that the first successful
    run does not have is an error: the finished runs are kept, and resumed once the name is correct.

    Programs that call this must do so under `if __name__ == "__main__":`, since the workers import them. Raises
    ScenarioError for mistakes in the file, before anything is written unless the mistake is a metric's name; also
    ValueError and OSError.
    """
    campaign = Campaign(RetriedOptions, **options)
    spec, read_from, folder = read_sweep(source)
    with campaign.show("checking the sweep"):
        runs, jobs = runs_of(spec), Jobs(spec, folder)
        require_flyable(spec, read_from, folder)
        plan = _plan(spec, jobs)
    into = made_folder(Path(out), (TABLE, REPORT))
    with alone_in(into):
        name = spec.name or (Path(source).stem if isinstance(source, str | Path) else "sweep")
        with Ledger.opened(into, plan, resume=campaign.options.resume, what="sweep", jobs="runs") as ledger:
            known = _Metrics(spec, read_from)
            for number, result in ledger.results.items():
                known.look(number, result)
            campaign.run(
                ledger, fly_job, {run.number: jobs.of(run) for run in runs}, retries=spec.retries,
                result_of=_result_of, then=known.look,
            )  # fmt: skip
        sweep = Sweep(spec, Rows.of(runs, ledger.results, plan), into, runs)
        with campaign.show("writing the table"):
            write_table(into / TABLE, sweep.rows, {"uwsim sweep": json.dumps(plan), "uwsim": version("uwsim")})
        if report:
            _report(sweep, name, jobs, campaign.show)
        return sweep


def _result_of(each: Finished) -> dict[str, Any]:
    return {**(each.result or {"metrics": {}, "error": each.error}), "trials": each.trials}


@dataclass
class _Metrics:
    """Looks at results until one shows that all metrics which the sweep names exist."""

    spec: SweepSpec
    source: SourceFile
    are_known: bool = False

    def look(self, number: int, result: Mapping[str, Any]) -> None:
        """Look at a run's result. Raises ScenarioError."""
        if not self.are_known and not result["error"]:
            self.are_known = require_metrics(self.spec, self.source, number, result["metrics"])


def _report(sweep: Sweep, name: str, jobs: Jobs, show: Show) -> None:
    from uwsim.campaigns.sweeps.report import write_report  # imported here, since matplotlib takes a second

    again = {}
    if not sweep.interrupted:
        for number in sweep.rows.worst(sweep.spec.objective, sweep.spec.worst):
            with show(f"flying run {number} again, with a recording"):
                folder = sweep.out / WORST / f"{number:06d}"
                row = next(row for row in sweep.rows.rows if row["run"] == number)
                expected = {name: row.get(name) for name in sweep.rows.metrics}
                for difference in fly_run_again(jobs.of(sweep.runs[number]), folder, expected):
                    logger.warning("run %d, flown again: %s", number, difference)
                again[number] = folder
    with show("drawing the report"):
        write_report(sweep.out / REPORT, name, sweep.spec, sweep.rows, len(sweep.runs), again)


def fly_again(
    source: str | Path | Mapping[str, Any], number: int, folder: str | Path, *, report: str = "full"
) -> list[str]:
    """Repeat one run of a sweep; write its scenario, recording, map and report to a folder.

    The run is first flown as in the sweep, without a recording. Return a sentence for each value that differs from it;
    there are none unless the machine is at fault. Raises ScenarioError, ValueError or OSError.
    """
    spec, _, beside = read_sweep(source)
    runs = runs_of(spec)
    if not 0 <= number < len(runs):
        raise ValueError(f"run = {number}: must be in [0, {len(runs) - 1}]")
    job = Jobs(spec, beside).of(runs[number])
    return fly_run_again(job, Path(folder), fly_job(job)["metrics"], report)


def _plan(spec: SweepSpec, jobs: Jobs) -> dict[str, Any]:
    """Return everything that determines the results of all runs."""
    files = {}
    for kind in FILES:
        levels = choices(spec.vary[kind]) if kind in spec.vary else []
        for job in [jobs.with_levels({kind: level}) for level in levels] or [jobs.with_levels({})]:
            if kind == "scenario":
                files[job.scenario] = scenario_fingerprint(load(job.scenario))
            elif job.mission is not None:
                files[job.mission] = str(job.mission_digest)
    decisive = spec.model_dump(mode="json", exclude={"name", "description", "objective", "require", "show", "worst"})
    text = json.dumps(decisive, sort_keys=True).encode()
    return {"sweep": hashlib.blake2b(text, digest_size=8).hexdigest(), "files": files, "build": build_fingerprint()}
