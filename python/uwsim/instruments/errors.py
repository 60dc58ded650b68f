"""Errors without memory, for what is measured in Python.

Each is a function of the seed, the name of what measures, the quantity and the time of the sample (Philox,
counter-based). Samples are therefore the same however often they are read, in a replay and after `restore_state`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.spec.sensor import Noise


@dataclass(frozen=True)
class Errors:
    """The errors of one instrument. name: of its random stream. rate_hz: of its samples. seed: returns the run's."""

    name: str
    rate_hz: float
    seed: Callable[[], int]

    def added(self, noise: Noise, channel: str, value: Floats, stamp_ns: int) -> Floats:
        """Return a quantity (n,) with its errors in the sample of a time."""
        std = np.hypot(noise.std, noise.density * np.sqrt(self.rate_hz))
        if std > 0.0:
            value = value + std * self._draw(channel, stamp_ns + 1, len(value))
        if noise.turn_on_std > 0.0:
            value = value + noise.turn_on_std * self._draw(channel, 0, len(value))
        if noise.quantum > 0.0:
            value = noise.quantum * np.round(value / noise.quantum)
        return value if noise.limits is None else np.clip(value, *noise.limits)

    def _draw(self, channel: str, count: int, width: int) -> Floats:
        """Return `width` normally distributed numbers for the sample `count`; 0 is the beginning of the run."""
        return normal_draws(self.seed(), f"sensor/{self.name}/{channel}", count, width)


def normal_draws(seed: int, stream: str, count: int, width: int) -> Floats:
    """Return `width` normally distributed numbers, which depend on seed, stream and count alone."""
    number = int.from_bytes(hashlib.blake2b(stream.encode(), digest_size=8).digest(), "little")
    key = np.array([seed, number], np.uint64)
    counter = np.array([0, count, 0, 0], np.uint64)  # the first word counts within a draw
    return np.random.Generator(np.random.Philox(key=key, counter=counter)).standard_normal(width)
