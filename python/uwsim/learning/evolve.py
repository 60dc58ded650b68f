"""Searches for a linear policy by CMA-ES (Hansen 2016, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772).

A generation is one batch: every candidate flies the same few episodes, with new seeds in each generation, so that no
candidate can memorise them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.learning.episodes import Episodes
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.policy import LinearPolicy
from uwsim.learning.returns import fly
from uwsim.learning.task import Task

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Generation:
    """Results of a generation: mean and best return of its candidates, and processor time used so far."""

    index: int
    mean: float
    best: float
    processor_s: float


def evolve(
    kind: type[Task],
    options: EpisodeOptions,
    *,
    generations: int,
    candidates: int = 16,
    episodes_each: int = 8,
    first_seed: int = 0,
    start: LinearPolicy | None = None,
    spread: float = 0.5,
    notify: Callable[[Generation], None] = lambda generation: None,
) -> LinearPolicy:
    """Return the mean of the last generation's distribution. Episodes are seeded consecutively from first_seed.

    start: the mean of the first candidates; by default, all weights are zero. spread: the standard deviation of their
    weights, each multiplied by the usual size of its input. The policy is for observations in their own units,
    regardless of `options.normalise`. Raises MissingExtraError if cma is not installed.
    """
    need_extra("cma", "learning by CMA-ES")
    import cma

    episodes = Episodes(kind, candidates * episodes_each, replace(options, normalise=False))
    free = free_weights(kind)
    stds = np.broadcast_to(1.0 / usual_sizes(kind), free.shape)[free]
    settings = {"popsize": candidates, "seed": first_seed + 1, "verbose": -9, "CMA_stds": stds}
    first = np.zeros(free.shape) if start is None else np.column_stack([start.weights, start.bias])
    strategy = cma.CMAEvolutionStrategy(first[free], spread, settings)
    begin = time.process_time()
    for index in range(generations):
        asked = strategy.ask()
        weights = np.zeros((candidates, *free.shape))
        weights[:, free] = asked
        seeds = first_seed + index * episodes_each + np.arange(episodes_each)
        total = fly(episodes, Candidates(weights, episodes_each), np.tile(seeds, candidates).tolist()).total
        earned = total.reshape(candidates, episodes_each).mean(axis=1)
        strategy.tell(asked, (-earned).tolist())
        notify(Generation(index, float(earned.mean()), float(earned.max()), time.process_time() - begin))
    found = np.zeros(free.shape)
    found[free] = strategy.mean
    return LinearPolicy(found[:, :-1].copy(), found[:, -1].copy())


def free_weights(kind: type[Task]) -> NDArray[np.bool_]:
    """Return a mask (axes, width + 1) of the free weights and, in the last column, the free biases.

    A vehicle that is symmetric to port and starboard acts mirrored in a mirrored situation, so half of the weights are
    zero. If a field has no mirror factors, all weights are free.
    """
    fields = kind.fields()
    if not all(field.mirror for field in fields):
        return np.ones((len(kind.action_names()), sum(field.width for field in fields) + 1), np.bool_)
    seen = np.array([*(factor for field in fields for factor in field.mirror), 1])
    return np.outer(kind.action_mirror(), seen) > 0


def usual_sizes(kind: type[Task]) -> Floats:
    """Return the usual size of each value in an observation, and 1 for the bias: (width + 1,)."""
    sizes = [size for field in kind.fields() for size in field.sizes]
    return np.array([*sizes, 1.0])


class Candidates:
    """k linear policies, as weights and biases (k, axes, width + 1). Each acts in episodes_each consecutive members."""

    def __init__(self, weights: Floats, episodes_each: int) -> None:
        self._weights, self._each = weights, episodes_each

    def __call__(self, observation: NDArray[np.float32]) -> Floats:
        """Return actions (n, axes)."""
        groups = observation.reshape(len(self._weights), self._each, -1).astype(np.float64)
        actions = groups @ self._weights[:, :, :-1].transpose(0, 2, 1) + self._weights[:, None, :, -1]
        return np.asarray(np.clip(actions, -1.0, 1.0).reshape(len(observation), -1))
