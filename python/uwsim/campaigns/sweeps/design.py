"""The design of a sweep: the values of each run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.campaigns.sweeps.spec import MAX_RUNS, Seeds, SweepSpec
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.variation import Level, Variation, choices, level_at


@dataclass(frozen=True)
class Run:
    """A run of a sweep. sample: equal for runs that differ only in their seeds. seed: None for the scenario's seed."""

    number: int
    sample: int
    seed: int | None
    levels: dict[str, Level]


def runs_of(spec: SweepSpec) -> list[Run]:
    """Return all runs, in order. Raises ScenarioError if there are too many."""
    count = _sample_count(spec)
    each = len(_seeds(spec, 0))
    if count * each > MAX_RUNS:
        raise ScenarioError(f"the sweep has {count * each:,} runs: must be at most {MAX_RUNS:,}")
    samples = _samples(spec)
    return [
        Run(sample * each + k, sample, seed, levels)
        for sample, levels in enumerate(samples)
        for k, seed in enumerate(_seeds(spec, sample))
    ]


def _sample_count(spec: SweepSpec) -> int:
    if spec.method == "grid":
        return math.prod(len(v.choices) if v.choices is not None else v.steps or 1 for v in spec.vary.values())
    samples = spec.samples or 1
    return samples * (len(spec.vary) + 2) if spec.method == "saltelli" else samples


def _seeds(spec: SweepSpec, sample: int) -> list[int | None]:
    seeds = spec.seeds
    if seeds is None:
        return [None]
    if isinstance(seeds, Seeds):
        if seeds.count is None:
            return [seeds.first + sample]
        return [seeds.first + k for k in range(seeds.count)]
    return list(seeds)


def _samples(spec: SweepSpec) -> list[dict[str, Level]]:
    names = list(spec.vary)
    if spec.method == "grid":
        levels = [_grid(variation) for variation in spec.vary.values()]
        return [dict(zip(names, combination, strict=True)) for combination in product(*levels)]
    units = _unit_samples(spec)
    return [{name: level_at(spec.vary[name], float(u)) for name, u in zip(names, row, strict=True)} for row in units]


def _grid(variation: Variation) -> list[Level]:
    if variation.choices is not None:
        return choices(variation)
    levels = [_rounded(level_at(variation, float(u))) for u in np.linspace(0.0, 1.0, variation.steps or 2)]
    return list({level.shown: level for level in levels}.values())  # whole numbers may occur twice


def _rounded(level: Level) -> Level:
    """Round off floating-point noise: 0.6000000000000001 becomes 0.6."""
    value = level.value if isinstance(level.value, int) else float(f"{level.value:.12g}")
    return Level(value, value)


def _unit_samples(spec: SweepSpec) -> Floats:
    """Return points (samples, variations) in the unit cube; all except random ones are drawn by scipy.stats.qmc."""
    random, width, count = np.random.default_rng(spec.seed), len(spec.vary), spec.samples or 1
    if spec.method == "random":
        return random.random((count, width))
    from scipy.stats import qmc  # imported here, since it takes a second

    if spec.method == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(width, rng=random).random(count))
    if spec.method == "sobol":
        return np.asarray(qmc.Sobol(width, rng=random).random(count))
    return saltelli(np.asarray(qmc.Sobol(2 * width, rng=random).random(count)))


def saltelli(pairs: Floats) -> Floats:
    """Return the points of Saltelli et al. (2010), Comput. Phys. Commun. 181, table 2, from pairs (n, 2 d) of points.

    The result is (n (d + 2), d): n points A, n points B, then for each variation i the points A with column i of B.
    """
    width = pairs.shape[1] // 2
    a, b = pairs[:, :width], pairs[:, width:]
    mixed = []
    for column in range(width):
        one = a.copy()
        one[:, column] = b[:, column]
        mixed.append(one)
    return np.concatenate([a, b, *mixed])
