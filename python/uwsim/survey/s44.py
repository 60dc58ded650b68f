"""How a depth grid fares against the orders of IHO S-44, vertically.

IHO Standards for Hydrographic Surveys, S-44, edition 6.1.0 (2022), Table 1: the total vertical uncertainty allowed at
the 95 % confidence level is TVU(d) = sqrt(a^2 + (b d)^2) at depth d. The coefficients stand here as they were handed to
the project; they were not read in the standard itself. An order asks for more than this (horizontal uncertainty,
features detected, coverage), so a grid that keeps its TVU need not be of that order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Order:
    """a [m]: what does not depend on depth. b: what grows with it."""

    name: str
    a_m: float
    b: float

    def tvu_m(self, depths_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the vertical uncertainty allowed at depths (any shape), positive down; above the water as at it."""
        return np.hypot(self.a_m, self.b * np.maximum(np.asarray(depths_m, np.float64), 0.0))


ORDERS = (
    Order("Exclusive", 0.15, 0.0075),
    Order("Special", 0.25, 0.0075),
    Order("1a", 0.5, 0.013),
    Order("1b", 0.5, 0.013),
    Order("2", 1.0, 0.023),
)
"""The strictest first. 1a and 1b differ in what features must be found, not in depth."""


def share_within(order: Order, errors_m: NDArray[np.floating], depths_m: NDArray[np.floating]) -> float:
    """Return the share of errors (n,) at true depths (n,) that are no larger than the order allows; nan for none."""
    if not len(errors_m):
        return float("nan")
    return float((np.abs(errors_m) <= order.tvu_m(depths_m)).mean())


def best_order(errors_m: NDArray[np.floating], depths_m: NDArray[np.floating]) -> Order | None:
    """Return the strictest order whose TVU holds for 95 % of the errors; None when there is none or no error."""
    return next((order for order in ORDERS if share_within(order, errors_m, depths_m) >= CONFIDENCE), None)
