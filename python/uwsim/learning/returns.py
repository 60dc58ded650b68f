"""Measures the returns of policies by flying one episode per seed, all simultaneously."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.short_repr import ShortRepr
from uwsim.learning.episodes import Episodes
from uwsim.learning.policy import LinearPolicy, Policy

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Flown(ShortRepr):
    """Results of one episode per seed.

    total: (n,), sum of rewards. steps: (n,), number of steps. figures: (steps, n) by name, NaN after the end.
    """

    total: Floats
    steps: NDArray[np.intp]
    figures: dict[str, Floats]


def fly(episodes: Episodes, policy: Policy, seeds: Sequence[int]) -> Flown:
    """Fly one episode per seed to its end. seeds: one per member.

    Raises ValueError for a LinearPolicy, whose inputs have units, if the observations are normalised.
    """
    if isinstance(policy, LinearPolicy) and episodes.normalise:
        raise ValueError(
            "policy: a LinearPolicy needs observations in their own units: EpisodeOptions(normalise=False)"
        )
    for member, seed in enumerate(seeds):
        episodes.seed(member, int(seed))
    observation = episodes.begin(np.ones(episodes.n, np.bool_))
    flying, ended = np.ones(episodes.n, np.bool_), np.zeros(episodes.n, np.bool_)
    total, steps = np.zeros(episodes.n), np.zeros(episodes.n, np.intp)
    rows: list[dict[str, Floats]] = []
    while flying.any():
        outcome = episodes.step(policy(observation), ended if ended.any() else None)  # ended ones fly on, uncounted
        observation = outcome.observation
        total[flying] += outcome.reward[flying]
        steps[flying] += 1
        rows.append({name: np.where(flying, values, np.nan) for name, values in outcome.figures.items()})
        ended = outcome.terminated | outcome.truncated
        flying &= ~ended
    names = rows[0] if rows else {}
    return Flown(
        total, steps, {name: np.array([row.get(name, np.full(episodes.n, np.nan)) for row in rows]) for name in names}
    )
