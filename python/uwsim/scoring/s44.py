"""The vertical orders of IHO S-44, and the orders that a depth grid meets.

IHO Standards for Hydrographic Surveys, S-44, edition 6.1.0 (2022), Table 1: the total vertical uncertainty allowed at
the 95 % confidence level is TVU(d) = sqrt(a^2 + (b d)^2) at depth d. The coefficients were supplied to the project and
have not been checked against the standard itself. An order has further requirements (horizontal uncertainty, feature
detection, coverage), so a grid that meets its TVU does not necessarily meet the order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Order:
    """An S-44 order. a_m: the depth-independent part of the uncertainty. b: the factor applied to depth."""

    name: str
    a_m: float
    b: float

    def tvu_m(self, depths_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the vertical uncertainty allowed at depths (any shape, positive down), clipped to at least 0."""
        return np.hypot(self.a_m, self.b * np.maximum(np.asarray(depths_m, np.float64), 0.0))


ORDERS = (
    Order("Exclusive", 0.15, 0.0075),
    Order("Special", 0.25, 0.0075),
    Order("1a", 0.5, 0.013),
    Order("1b", 0.5, 0.013),
    Order("2", 1.0, 0.023),
)
"""Strictest first. 1a and 1b differ in the features that must be detected, not in depth."""


def share_within(order: Order, errors_m: NDArray[np.floating], depths_m: NDArray[np.floating]) -> float:
    """Return the fraction of errors (n,), at true depths (n,), within the limit of the order; NaN if there are none."""
    if not len(errors_m):
        return float("nan")
    return float((np.abs(errors_m) <= order.tvu_m(depths_m)).mean())


def best_order(errors_m: NDArray[np.floating], depths_m: NDArray[np.floating]) -> Order | None:
    """Return the strictest order whose limit is met by 95 % of the errors, or None if there is no such order."""
    return next((order for order in ORDERS if share_within(order, errors_m, depths_m) >= CONFIDENCE), None)
