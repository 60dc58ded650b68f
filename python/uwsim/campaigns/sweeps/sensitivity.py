"""Sensitivity: how strongly each metric depends on each varied value."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from uwsim.base.arrays import Floats
from uwsim.campaigns.sweeps.rows import Rows
from uwsim.campaigns.sweeps.spec import SweepSpec

FEWEST = 4
"""With fewer runs, the result is NaN."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """The dependence of each metric on each variation.

    metrics (m,), varied (v,): names. values (m, v): NaN where unknown. kinds (v,): the meaning of a column of `values`:
    "rank" for numbers: Spearman's rank correlation, from -1 to 1; "share" for choices: the share of the variance
    explained by the per-choice means (correlation ratio, eta squared), from 0 to 1.
    """

    metrics: list[str]
    varied: list[str]
    kinds: list[str]
    values: Floats


@dataclass(frozen=True)
class SobolIndex:
    """Sobol' indices of a variation: the shares of a metric's variance that it explains on its own and in total."""

    metric: str
    varied: str
    first_order: float
    total_order: float


def sensitivity(rows: Rows, metrics: Sequence[str]) -> Sensitivity:
    """Return the sensitivity of metrics to the variations."""
    kinds = ["rank" if rows.is_numeric(name) else "share" for name in rows.varied]
    values = np.full((len(metrics), len(rows.varied)), np.nan)
    for column, (name, kind) in enumerate(zip(rows.varied, kinds, strict=True)):
        for row, metric in enumerate(metrics):
            values[row, column] = _rank(rows, name, metric) if kind == "rank" else _share(rows, name, metric)
    return Sensitivity(list(metrics), rows.varied, kinds, values)


def _rank(rows: Rows, varied: str, metric: str) -> float:
    x, y = rows.numbers(varied), rows.numbers(metric)
    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < FEWEST or np.ptp(x[known]) == 0.0 or np.ptp(y[known]) == 0.0:
        return float("nan")
    return float(spearmanr(x[known], y[known]).statistic)


def _share(rows: Rows, varied: str, metric: str) -> float:
    y = rows.numbers(metric)
    labels = np.array([str(row.get(varied)) for row in rows.rows])
    known = np.isfinite(y)
    y, labels = y[known], labels[known]
    if len(y) < FEWEST or y.var() == 0.0 or len(set(labels)) < 2:
        return float("nan")
    between = sum((labels == label).sum() * (y[labels == label].mean() - y.mean()) ** 2 for label in set(labels))
    return float(between / (len(y) * y.var()))


def sobol_indices_of(spec: SweepSpec, rows: Rows, metrics: Sequence[str]) -> list[SobolIndex]:
    """Return Sobol' indices for `method: saltelli`, for the metrics that all runs have, averaged over seeds.

    Estimated by scipy.stats.sobol_indices as in Saltelli et al. (2010), Comput. Phys. Commun. 181, 259-270.
    """
    if spec.method != "saltelli" or spec.samples is None:
        return []
    from scipy.stats import sobol_indices

    n, width = spec.samples, len(rows.varied)
    found = []
    for metric in metrics:
        means = _means_by_sample(rows, metric, n * (width + 2))
        if not np.isfinite(means).all() or np.ptp(means) == 0.0:
            continue
        a, b, mixed = means[:n], means[n : 2 * n], means[2 * n :].reshape(width, 1, n)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            indices = sobol_indices(func={"f_A": a[None], "f_B": b[None], "f_AB": mixed}, n=n)
        found += [
            SobolIndex(metric, name, float(indices.first_order.ravel()[k]), float(indices.total_order.ravel()[k]))
            for k, name in enumerate(rows.varied)
        ]
    return found


def _means_by_sample(rows: Rows, metric: str, count: int) -> Floats:
    samples, values = np.array([row["sample"] for row in rows.rows], int), rows.numbers(metric)
    sums, numbers = np.bincount(samples, values, count), np.bincount(samples, minlength=count)
    return np.asarray(np.divide(sums, numbers, out=np.full(count, np.nan), where=numbers > 0))
