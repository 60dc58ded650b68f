"""The rows of a sweep's table, one per finished run, and queries on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.named import did_you_mean
from uwsim.campaigns.sweeps.design import Run
from uwsim.campaigns.sweeps.spec import Limits, Objective

PROVENANCE = ("run", "sample", "seed", "error", "trials", "scenario_digest", "build", "run_wall_s", "flight_wall_s")


@dataclass(frozen=True, eq=False)
class Rows:
    """The table of a sweep.

    rows: values keyed by column, in run order. varied: the columns of varied values. metrics: the columns of results.
    """

    rows: list[dict[str, Any]]
    varied: list[str]
    metrics: list[str]

    @classmethod
    def of(cls, runs: list[Run], results: Mapping[int, Mapping[str, Any]], plan: Mapping[str, Any]) -> Rows:
        """Build the rows for finished runs from all runs and the results so far."""
        rows, metrics = [], dict[str, None]()
        for run in runs:
            result = results.get(run.number)
            if result is None:
                continue
            rows.append(
                {
                    "run": run.number,
                    "sample": run.sample,
                    "seed": result.get("seed", run.seed),
                    **{name: level.shown for name, level in run.levels.items()},
                    **result["metrics"],
                    "error": result["error"],
                    "trials": result.get("trials", 1),
                    "scenario_digest": result.get("scenario_digest"),
                    "build": plan["build"],
                    "run_wall_s": result.get("run_wall_s"),
                    "flight_wall_s": result.get("flight_wall_s"),
                }
            )
            metrics.update(dict.fromkeys(result["metrics"]))
        varied = list(runs[0].levels) if runs else []
        return cls(rows, varied, [name for name in metrics if name not in varied])

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def columns(self) -> list[str]:
        """The names of all columns, in table order."""
        return [*PROVENANCE[:3], *self.varied, *self.metrics, *PROVENANCE[3:]]

    @property
    def failed(self) -> list[dict[str, Any]]:
        """The rows of runs that failed."""
        return [row for row in self.rows if row["error"]]

    @property
    def ended_early(self) -> list[dict[str, Any]]:
        """The rows of runs that did not fail, but were ended by anything but their mission or time limit."""
        return [row for row in self.rows if not row["error"] and row.get("ended_early")]

    def without(self, metric: str) -> int:
        """Return the number of runs that did not fail, but have no value of a metric, such as after an early end."""
        return sum(not row["error"] and row.get(metric) is None for row in self.rows)

    def numbers(self, column: str) -> Floats:
        """Return a column (n,) as numbers, with NaN for rows without one, such as failed runs."""
        values = [row.get(column) for row in self.rows]
        return np.array([float(v) if isinstance(v, bool | int | float) else np.nan for v in values], np.float64)

    def is_numeric(self, column: str) -> bool:
        """Return whether a column contains only numbers."""
        values = [value for row in self.rows if (value := row.get(column)) is not None]
        return bool(values) and all(isinstance(value, bool | int | float) for value in values)

    def differing(self) -> list[str]:
        """Return the numeric metrics that differ between runs."""
        found = []
        for name in self.metrics:
            if self.is_numeric(name):
                values = self.numbers(name)
                values = values[np.isfinite(values)]
                if len(values) > 1 and np.ptp(values) > 0.0:
                    found.append(name)
        return found

    def require_metric(self, name: str, what: str) -> None:
        """Raise ValueError if no run has a metric of this name."""
        if self.metrics and name not in self.metrics:
            raise ValueError(f"{what} = {name}: no such metric{did_you_mean(name, self.metrics)}")

    def missed(self, require: Mapping[str, Limits]) -> dict[str, int]:
        """Return the number of rows outside each limit, including rows without the metric. Raises ValueError."""
        found = {}
        for name, limits in require.items():
            self.require_metric(name, "require")
            values = self.numbers(name)
            low = -np.inf if limits.low is None else limits.low
            high = np.inf if limits.high is None else limits.high
            found[name] = int((~((values >= low) & (values <= high))).sum())
        return found

    def worst(self, objective: Objective | None, count: int) -> list[int]:
        """Return the numbers of the worst runs that have the metric, worst first. Raises ValueError."""
        if objective is None or not self.rows:
            return []
        self.require_metric(objective.metric, "objective.metric")
        values = self.numbers(objective.metric) * (1.0 if objective.best == "high" else -1.0)
        order = np.argsort(values, kind="stable")  # NaN last
        return [int(self.rows[k]["run"]) for k in order[:count] if np.isfinite(values[k])]
