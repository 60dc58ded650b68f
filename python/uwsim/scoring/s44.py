"""The orders of IHO S-44: the uncertainties that they allow, and the orders that a depth grid meets.

IHO Standards for Hydrographic Surveys, S-44, edition 6.1.0 (2022), Table 1: the total vertical uncertainty allowed at
the 95 % confidence level is TVU(d) = sqrt(a^2 + (b d)^2) at depth d, and the total horizontal uncertainty is
THU(d) = c + f d. The coefficients were supplied to the project and have not been checked against the standard itself.
An order has further requirements (feature detection, coverage), so that soundings which meet its uncertainties do not
necessarily meet the order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Order:
    """An S-44 order.

    a_m, b: the part of the vertical uncertainty that does not depend on depth, and the factor applied to depth.
    thu_fixed_m, thu_share: the same of the horizontal uncertainty.
    """

    name: str
    a_m: float
    b: float
    thu_fixed_m: float
    thu_share: float = 0.0

    def tvu_m(self, depths_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the vertical uncertainty allowed at depths (any shape, positive down), clipped to at least 0."""
        return np.hypot(self.a_m, self.b * np.maximum(np.asarray(depths_m, np.float64), 0.0))

    def thu_m(self, depths_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the horizontal uncertainty allowed at depths (any shape, positive down), clipped to at least 0."""
        return self.thu_fixed_m + self.thu_share * np.maximum(np.asarray(depths_m, np.float64), 0.0)


ORDERS = (
    Order("Exclusive", 0.15, 0.0075, 1.0),
    Order("Special", 0.25, 0.0075, 2.0),
    Order("1a", 0.5, 0.013, 5.0, 0.05),
    Order("1b", 0.5, 0.013, 5.0, 0.05),
    Order("2", 1.0, 0.023, 20.0, 0.10),
)
"""Strictest first. 1a and 1b differ in the features that must be detected, not in uncertainty."""


def share_within(order: Order, errors_m: NDArray[np.floating], depths_m: NDArray[np.floating]) -> float:
    """Return the fraction of errors (n,), at true depths (n,), within the limit of the order; NaN if there are none."""
    if not len(errors_m):
        return float("nan")
    return float((np.abs(errors_m) <= order.tvu_m(depths_m)).mean())


def best_order(errors_m: NDArray[np.floating], depths_m: NDArray[np.floating]) -> Order | None:
    """Return the strictest order whose limit is met by 95 % of the errors, or None if there is no such order."""
    return next((order for order in ORDERS if share_within(order, errors_m, depths_m) >= CONFIDENCE), None)
