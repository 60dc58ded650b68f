"""Check: a comparison of an expected value with the simulated value, with its error and tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Check:
    """A comparison. error and tolerance are relative to a scale; see relative(), within() and along()."""

    group: str
    name: str
    expected: float
    got: float
    error: float
    tolerance: float
    unit: str = ""

    @property
    def passed(self) -> bool:
        """Whether the error is finite and within the tolerance."""
        return math.isfinite(self.error) and self.error <= self.tolerance


def relative(group: str, name: str, expected: float, got: float, tolerance: float, unit: str = "") -> Check:
    """Compare a value with a non-zero expected value; the error is relative to the expected value."""
    return Check(group, name, expected, got, abs(got - expected) / abs(expected), tolerance, unit)


def within(group: str, name: str, expected: float, got: float, scale: float, tolerance: float, unit: str = "") -> Check:
    """Compare a value with an expected value that may be zero; the error is relative to `scale`."""
    return Check(group, name, expected, got, abs(got - expected) / scale, tolerance, unit)


def along(
    group: str, name: str, expected: ArrayLike, got: ArrayLike, scale: float, tolerance: float, unit: str = ""
) -> Check:
    """Compare two curves at the point of their largest difference; the error is relative to `scale`."""
    reference, found = np.asarray(expected, np.float64), np.asarray(got, np.float64)
    distance = np.abs(found - reference) / scale
    worst = int(np.argmax(np.where(np.isfinite(distance), distance, np.inf)))
    return Check(group, name, float(reference[worst]), float(found[worst]), float(distance[worst]), tolerance, unit)


def at_most(group: str, name: str, limit: float, got: float, unit: str = "") -> Check:
    """Compare a value with its upper limit; the error is the ratio of the value to the limit."""
    return Check(group, f"{name} at most", limit, got, got / limit, 1.0, unit)
