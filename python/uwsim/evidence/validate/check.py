"""Check: a comparison of an expected value with the simulated value, with its error and tolerance.

A suite is a table of them. One that follows from a curve has it, too: what is drawn of a suite are its curves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.arrays import Floats


class Curve(NamedTuple):
    """Expected and computed values along x (n,), numbers or names. lines: (n,) each, by name, the expected one first.

    title: by default the check's name.
    """

    x: NDArray[Any]
    lines: Mapping[str, Floats]
    across: str = "time [s]"
    up: str = ""
    title: str = ""


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
    curve: Curve | None = field(default=None, compare=False, repr=False)

    @property
    def passed(self) -> bool:
        """Whether the error is finite and within the tolerance."""
        return math.isfinite(self.error) and self.error <= self.tolerance

    @property
    def cells(self) -> tuple[str, ...]:
        """The texts of a row, without the result: group, name, expected, computed, error, tolerance."""
        unit = f" {self.unit}" if self.unit else ""
        values = f"{self.expected:.7g}{unit}", f"{self.got:.7g}{unit}"
        return self.group, self.name, *values, f"{self.error:.1e}", f"{self.tolerance:.0e}"

    def to_dict(self) -> dict[str, Any]:
        """Return the check without its curve, and whether it passed."""
        values = asdict(replace(self, curve=None))
        del values["curve"]
        return {**values, "passed": self.passed}


def verdict(checks: list[Check]) -> str:
    """Return how many checks there are, and how many of them are missed."""
    misses = sum(not check.passed for check in checks)
    return f"{len(checks)} checks, " + (f"{misses} missed" if misses else "all within tolerance")


def relative(group: str, name: str, expected: float, got: float, tolerance: float, unit: str = "") -> Check:
    """Compare a value with a non-zero expected value; the error is relative to the expected value."""
    return Check(group, name, expected, got, abs(got - expected) / abs(expected), tolerance, unit)


def within(group: str, name: str, expected: float, got: float, scale: float, tolerance: float, unit: str = "") -> Check:
    """Compare a value with an expected value that may be zero; the error is relative to `scale`."""
    return Check(group, name, expected, got, abs(got - expected) / scale, tolerance, unit)


def along(
    group: str, name: str, expected: ArrayLike, got: ArrayLike, scale: float, tolerance: float, unit: str = "", *,
    x: ArrayLike | None = None, across: str = "time [s]",
) -> Check:  # fmt: skip
    """Compare two curves at the point of their largest difference; the error is relative to `scale`.

    x: where the values are, with which the curves are drawn.
    """
    reference, found = np.asarray(expected, np.float64), np.asarray(got, np.float64)
    distance = np.abs(found - reference) / scale
    worst = int(np.argmax(np.where(np.isfinite(distance), distance, np.inf)))
    curve = None if x is None else Curve(np.asarray(x, np.float64), {"expected": reference, "got": found}, across, unit)
    return Check(
        group, name, float(reference[worst]), float(found[worst]), float(distance[worst]), tolerance, unit, curve
    )


def at_most(group: str, name: str, limit: float, got: float, unit: str = "") -> Check:
    """Compare a value with its upper limit; the error is the ratio of the value to the limit."""
    return Check(group, f"{name} at most", limit, got, got / limit, 1.0, unit)
