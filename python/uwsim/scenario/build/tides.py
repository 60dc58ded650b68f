"""The harmonic constituents of tides at a time.

Arguments: mean longitudes of Moon and Sun after the Explanatory Supplement to the Astronomical Ephemeris (1961), and
the Doodson numbers of Foreman 1977, "Manual for tidal heights analysis and prediction", Pacific Marine Science Report
77-10. Nodal corrections: Pugh 1987, "Tides, surges and mean sea-level", table 4.3, within some 2 % of those that sum
the satellites of each constituent. They change over 18.6 years, and are taken for constant in a run.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

EPOCH = datetime(1899, 12, 31, 12, tzinfo=UTC)
LONGITUDES_DEG = np.array([  # constant, per day, per (10000 days)^2 and ^3: s, h, p, N' = -N
    [270.434164, 13.1763965268, -0.0000850, 0.000000039],
    [279.696678, 0.9856473354, 0.00002267, 0.0],
    [334.329556, 0.1114040803, -0.0007739, -0.00000026],
    [-259.183275, 0.0529539222, -0.0001557, -0.000000050],
])  # fmt: skip
DOODSON = {  # multiples of tau (the mean lunar time), s, h and p, and a constant [cycles]
    "M2": (2, 0, 0, 0, 0.0), "S2": (2, 2, -2, 0, 0.0), "N2": (2, -1, 0, 1, 0.0), "K2": (2, 2, 0, 0, 0.0),
    "K1": (1, 1, 0, 0, -0.75), "O1": (1, -1, 0, 0, -0.25), "P1": (1, 1, -2, 0, -0.25), "Q1": (1, -2, 0, 1, -0.25),
    "M4": (4, 0, 0, 0, 0.0), "MS4": (4, 2, -2, 0, 0.0),
}  # fmt: skip
NODAL = {  # factor's constant and cos N, phase's sin N [deg]
    "M2": (1.0, -0.037, -2.1), "N2": (1.0, -0.037, -2.1), "K2": (1.024, 0.286, -17.7), "K1": (1.006, 0.115, -8.9),
    "O1": (1.009, 0.187, 10.8), "Q1": (1.009, 0.187, 10.8),
}  # fmt: skip
OVERTIDES = {"M4": ("M2", "M2"), "MS4": ("M2", "S2")}
DAY_S = 86400.0


class Harmonic(NamedTuple):
    """A constituent: amplitude times factor, and cos(speed_rad_s t + argument_rad - its Greenwich phase lag)."""

    factor: float
    speed_rad_s: float
    argument_rad: float


def harmonic(constituent: str, begin: str) -> Harmonic:
    """Return a constituent of DOODSON, t being the time since `begin` (ISO 8601, UTC by default)."""
    time = datetime.fromisoformat(begin)
    time = time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
    days = (time - EPOCH).total_seconds() / DAY_S
    tens = days / 1e4
    s, h, p, minus_node = LONGITUDES_DEG @ [1.0, days, tens**2, tens**3] / 360.0
    day = (time.hour + (time.minute + (time.second + 1e-6 * time.microsecond) / 60.0) / 60.0) / 24.0
    slopes = LONGITUDES_DEG @ [0.0, 1.0, 2e-4 * tens, 3e-4 * tens**2] / 360.0
    *numbers, constant = DOODSON[constituent]
    argument = np.dot(numbers, (day + h - s, s, h, p)) + constant
    speed = np.dot(numbers, (1.0 + slopes[1] - slopes[0], *slopes[:3]))  # cycles per day
    node_rad = -math.tau * minus_node
    factor, shift_deg = 1.0, 0.0
    for part in OVERTIDES.get(constituent, (constituent,)):
        mean, cosine, sine_deg = NODAL.get(part, (1.0, 0.0, 0.0))
        factor *= mean + cosine * math.cos(node_rad)
        shift_deg += sine_deg * math.sin(node_rad)
    turn_rad = math.tau * (argument % 1.0) + math.radians(shift_deg)
    return Harmonic(factor, math.tau * float(speed) / DAY_S, float(turn_rad))
