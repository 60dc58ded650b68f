"""The cost of a sweep, estimated from a few of its runs before all are flown."""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.campaigns.sweeps.check import Jobs, require_flyable, require_metrics
from uwsim.campaigns.sweeps.design import runs_of
from uwsim.campaigns.sweeps.job import fly_job
from uwsim.campaigns.sweeps.spec import read_sweep


@dataclass(frozen=True)
class SweepPlan:
    """The expected cost of a sweep.

    runs: number of runs. tried: the numbers of the runs that were flown for this estimate. processor_s: the processor
    time of each such run. failed: the errors of failed runs, by number. memory_bytes: peak memory of the process that
    flew them, an estimate for a worker's. row_bytes: size of a run's line in the ledger. metrics: the columns of their
    results.
    """

    runs: int
    tried: tuple[int, ...]
    processor_s: tuple[float, ...]
    failed: dict[int, str]
    memory_bytes: int
    row_bytes: int
    metrics: tuple[str, ...]

    @property
    def total_s(self) -> float:
        """Processor time of all runs [s], if they cost as much as the tried ones on average."""
        return self.runs * sum(self.processor_s) / len(self.processor_s)


def plan_sweep(source: str | Path | Mapping[str, Any]) -> SweepPlan:
    """Fly the first, the middle and the last run in this process, and estimate the cost of all; write nothing.

    The first run is flown twice, and its first flight is not counted, since it also loads data that later runs share.
    Raises ScenarioError for mistakes in the sweep, including metrics that no run has.
    """
    spec, read_from, folder = read_sweep(source)
    runs, jobs = runs_of(spec), Jobs(spec, folder)
    require_flyable(spec, read_from, folder)
    tried = sorted({0, len(runs) // 2, len(runs) - 1})
    fly_job(jobs.of(runs[0]))
    costs, failed, metrics, row_bytes = [], {}, dict[str, None](), 0
    for number in tried:
        begun_s = time.process_time()
        result = fly_job(jobs.of(runs[number]))
        costs.append(time.process_time() - begun_s)
        row_bytes = max(row_bytes, len(json.dumps(result)))
        if result["error"]:
            failed[number] = str(result["error"])
        else:
            require_metrics(spec, read_from, number, result["metrics"])
            metrics.update(dict.fromkeys(result["metrics"]))
    memory_bytes = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return SweepPlan(len(runs), tuple(tried), tuple(costs), failed, memory_bytes, row_bytes, tuple(metrics))
