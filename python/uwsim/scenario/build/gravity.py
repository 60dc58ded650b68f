"""The acceleration due to gravity at a scenario's place, which its water has, and with it all that has weight there.

WGS 84's normal gravity on the ellipsoid, by Somigliana's closed formula (NIMA TR8350.2, third edition, 2000, eq. 4-1
and table 3.4): 9.780 at the equator to 9.832 m/s2 at the poles. Anomalies, of up to some 0.003 m/s2, and the increase
with depth, of 2.2e-6 1/s2 in the sea, are not modelled.
"""

from __future__ import annotations

import math

from uwsim import _core
from uwsim.scenario.spec.earth import Earth

EQUATOR_M_S2 = 9.7803253359
FORMULA = 0.00193185265241
ECCENTRICITY_2 = 0.00669437999014
STANDARD_M_S2 = _core.Water().gravity_m_s2
"""Standard gravity (CGPM 1901), of worlds without a place on Earth."""


def gravity_m_s2(earth: Earth | None) -> float:
    """Return the acceleration due to gravity at the world's origin; standard gravity without `earth`."""
    if earth is None:
        return STANDARD_M_S2
    sine_2 = math.sin(math.radians(earth.latitude_deg)) ** 2
    return EQUATOR_M_S2 * (1.0 + FORMULA * sine_2) / math.sqrt(1.0 - ECCENTRICITY_2 * sine_2)
