"""The harmonic constituents of tides at a time.

Arguments: mean longitudes of Moon and Sun after the Explanatory Supplement to the Astronomical Ephemeris (1961), and
the Doodson numbers of Foreman 1977, "Manual for tidal heights analysis and prediction", Pacific Marine Science Report
77-10. Nodal corrections: Pugh 1987, "Tides, surges and mean sea-level", table 4.3, and for J1 and OO1 Schureman 1958,
"Manual of harmonic analysis and prediction of tides", to first order. They change over 18.6 years, and are taken for
constant in a run.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

EPOCH = datetime(1899, 12, 31, 12, tzinfo=UTC)
LONGITUDES_DEG = np.array([  # constant, per day, per (10000 days)^2 and ^3: s, h, p, N' = -N, p1
    [270.434164, 13.1763965268, -0.0000850, 0.000000039],
    [279.696678, 0.9856473354, 0.00002267, 0.0],
    [334.329556, 0.1114040803, -0.0007739, -0.00000026],
    [-259.183275, 0.0529539222, -0.0001557, -0.000000050],
    [281.220844, 0.0000470684, 0.0000339, 0.000000070],
])  # fmt: skip
DOODSON = {  # multiples of tau (the mean lunar time), s, h, p and p1, and a constant [cycles]
    "SSA": (0, 0, 2, 0, 0, 0.0), "MM": (0, 1, 0, -1, 0, 0.0), "MF": (0, 2, 0, 0, 0, 0.0),
    "2Q1": (1, -3, 0, 2, 0, -0.25), "Q1": (1, -2, 0, 1, 0, -0.25), "RHO": (1, -2, 2, -1, 0, -0.25),
    "O1": (1, -1, 0, 0, 0, -0.25), "P1": (1, 1, -2, 0, 0, -0.25), "K1": (1, 1, 0, 0, 0, -0.75),
    "J1": (1, 2, 0, -1, 0, -0.75), "OO1": (1, 3, 0, 0, 0, -0.75),
    "2N2": (2, -2, 0, 2, 0, 0.0), "MU2": (2, -2, 2, 0, 0, 0.0), "N2": (2, -1, 0, 1, 0, 0.0),
    "NU2": (2, -1, 2, -1, 0, 0.0), "M2": (2, 0, 0, 0, 0, 0.0), "LAM2": (2, 1, -2, 1, 0, -0.5),
    "L2": (2, 1, 0, -1, 0, -0.5), "T2": (2, 2, -3, 0, 1, 0.0), "S2": (2, 2, -2, 0, 0, 0.0),
    "R2": (2, 2, -1, 0, -1, -0.5), "K2": (2, 2, 0, 0, 0, 0.0), "M3": (3, 0, 0, 0, 0, -0.5),
}  # fmt: skip
LUNAR = (1.0, -0.037, -2.1)
NODAL = {  # factor's constant and cos N, phase's sin N [deg]
    "MM": (1.0, -0.130, 0.0), "MF": (1.043, 0.414, -23.7),
    **dict.fromkeys(("2Q1", "Q1", "RHO", "O1"), (1.009, 0.187, 10.8)),
    "K1": (1.006, 0.115, -8.9), "J1": (1.013, 0.168, -12.9), "OO1": (1.103, 0.650, -36.7),
    **dict.fromkeys(("2N2", "MU2", "N2", "NU2", "M2", "LAM2"), LUNAR), "K2": (1.024, 0.286, -17.7),
    "M3": (1.0, -0.056, -3.2),
}  # fmt: skip
NODAL_L2 = (  # of the sum 1 + amplitude exp(i angle): amplitude, and multiples of 2 p and N in the angle
    (-0.2505, 1, 0), (-0.1102, 1, -1), (-0.0156, 1, -2), (-0.0370, 0, 1),
)  # fmt: skip
SHALLOW: Mapping[str, Mapping[str, int]] = {  # multiples of others
    "MSF": {"S2": 1, "M2": -1}, "2SM2": {"S2": 2, "M2": -1}, "MK3": {"M2": 1, "K1": 1}, "2MK3": {"M2": 2, "K1": -1},
    "MN4": {"M2": 1, "N2": 1}, "M4": {"M2": 2}, "MS4": {"M2": 1, "S2": 1}, "S4": {"S2": 2}, "M6": {"M2": 3},
    "S6": {"S2": 3}, "M8": {"M2": 4},
}  # fmt: skip
CONSTITUENTS = (*DOODSON, *SHALLOW)
"""Those of NOAA's tables by their names there, without SA, S1 and M1, whose arguments differ between agencies."""
DAY_S = 86400.0


class Harmonic(NamedTuple):
    """A constituent: amplitude times factor, and cos(speed_rad_s t + argument_rad - its Greenwich phase lag)."""

    factor: float
    speed_rad_s: float
    argument_rad: float


def harmonic(constituent: str, begin: str) -> Harmonic:
    """Return a constituent of CONSTITUENTS, t being the time since `begin` (ISO 8601, UTC by default)."""
    time = datetime.fromisoformat(begin)
    time = time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
    days = (time - EPOCH).total_seconds() / DAY_S
    tens = days / 1e4
    s, h, p, minus_node, p1 = LONGITUDES_DEG @ [1.0, days, tens**2, tens**3] / 360.0
    day = (time.hour + (time.minute + (time.second + 1e-6 * time.microsecond) / 60.0) / 60.0) / 24.0
    slopes = LONGITUDES_DEG @ [0.0, 1.0, 2e-4 * tens, 3e-4 * tens**2] / 360.0
    node_rad = -math.tau * minus_node
    factor, speed, turn_rad = 1.0, 0.0, 0.0
    for part, count in SHALLOW.get(constituent, {constituent: 1}).items():
        *numbers, constant = DOODSON[part]
        argument = np.dot(numbers, (day + h - s, s, h, p, p1)) + constant
        size, ahead_rad = _nodal(part, node_rad, math.tau * p)
        factor *= size ** abs(count)
        turn_rad += count * (math.tau * (argument % 1.0) + ahead_rad)
        speed += count * np.dot(numbers, (1.0 + slopes[1] - slopes[0], *slopes[:3], slopes[4]))  # cycles per day
    return Harmonic(factor, math.tau * float(speed) / DAY_S, float(turn_rad))


def _nodal(part: str, node_rad: float, perigee_rad: float) -> tuple[float, float]:
    """Return factor and phase [rad] of the nodes, for L2 also of the Moon's perigee."""
    if part == "L2":
        turns = ((size, 2.0 * twice * perigee_rad + nodes * node_rad) for size, twice, nodes in NODAL_L2)
        found = 1.0 + sum(cmath.rect(size, angle) for size, angle in turns)
        return abs(found), cmath.phase(found)
    mean, cosine, sine_deg = NODAL.get(part, (1.0, 0.0, 0.0))
    return mean + cosine * math.cos(node_rad), math.radians(sine_deg) * math.sin(node_rad)
