"""Finds a linear policy by CMA-ES: Hansen 2016, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772.

A generation is one batch: every candidate flies the same few episodes, whose seeds are new in each generation, so that
none can learn them by heart.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.extras import need_extra
from uwsim.learning.episodes import Episodes
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.policy import LinearPolicy
from uwsim.learning.returns import fly
from uwsim.learning.task import Task

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Generation:
    """One generation: mean and best return of its candidates, the processor time so far."""

    index: int
    mean: float
    best: float
    processor_s: float


def evolve(
    kind: type[Task],
    options: EpisodeOptions,
    *,
    generations: int,
    candidates: int = 24,
    episodes_each: int = 8,
    first_seed: int = 0,
    spread: float = 0.3,
    told: Callable[[Generation], None] = lambda generation: None,
) -> LinearPolicy:
    """Return the mean of the last generation's distribution. The seeds of episodes begin with first_seed.

    spread: of the first candidates' weights about zero. Raises MissingExtraError without `cma`.
    """
    need_extra("cma", "learn", "learning by CMA-ES")
    import cma

    episodes = Episodes(kind, candidates * episodes_each, options)
    axes, width = episodes.action_space.shape[0], flat_width(episodes)
    settings = {"popsize": candidates, "seed": first_seed + 1, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(np.zeros(axes * (width + 1)), spread, settings)
    begin = time.process_time()
    for index in range(generations):
        asked = np.array(strategy.ask())
        seeds = first_seed + index * episodes_each + np.arange(episodes_each)
        total = fly(episodes, Candidates(asked, axes, episodes_each), np.tile(seeds, candidates).tolist()).total
        earned = total.reshape(candidates, episodes_each).mean(axis=1)
        strategy.tell(list(asked), (-earned).tolist())
        told(Generation(index, float(earned.mean()), float(earned.max()), time.process_time() - begin))
    weights = np.asarray(strategy.result.xfavorite).reshape(axes, width + 1)
    return LinearPolicy(weights[:, :-1].copy(), weights[:, -1].copy())


def flat_width(episodes: Episodes) -> int:
    """Return the width of observations that are one array. Raises ValueError for others."""
    shape = episodes.observation_space.shape
    if shape is None or len(shape) != 1:
        raise ValueError(
            f"task {type(episodes.task).__name__}: a linear policy needs observations of one array (width,)"
        )
    return shape[0]


class Candidates:
    """Linear policies, one for each row of parameters; each acts in as many members, one after the other."""

    def __init__(self, parameters: Floats, axes: int, episodes_each: int) -> None:
        self._each = episodes_each
        self._weights = parameters.reshape(len(parameters), axes, -1)

    def __call__(self, observation: NDArray[np.float32]) -> Floats:
        """Return actions (n, axes)."""
        groups = observation.reshape(len(self._weights), self._each, -1).astype(np.float64)
        actions = np.einsum("caw,cew->cea", self._weights[:, :, :-1], groups) + self._weights[:, None, :, -1]
        return np.asarray(np.clip(actions, -1.0, 1.0).reshape(len(observation), -1))
