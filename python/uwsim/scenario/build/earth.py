"""The place on Earth of a scenario decides gravity, which its water has, and the magnetic field (WMM).

WGS 84's normal gravity on the ellipsoid, by Somigliana's closed formula (NIMA TR8350.2, third edition, 2000, eq. 4-1
and table 3.4): 9.780 at the equator to 9.832 m/s2 at the poles. Anomalies, of up to some 0.003 m/s2, and the increase
with depth, of 2.2e-6 1/s2 in the sea, are not modelled.

By pygeomag: WMM 2020 for the years 2020 to 2025, WMM 2025 for 2025 to 2030, degree 12, at the height of the ellipsoid.
The model's declination is within about 0.4 deg (one standard deviation) in middle latitudes; it has no crustal field.
NOAA and BGS, "The US/UK World Magnetic Model for 2025-2030", 2024.
"""

from __future__ import annotations

import math
from functools import cache

from uwsim import _core
from uwsim.base.extras import need_extra
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.settings import Earth

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


NEXT_MODEL = 2025.0
LEAST_HORIZONTAL_UT = 2.0
"""Below this, compasses are unreliable: the WMM's blackout zone around the magnetic poles."""


def compass_field(earth: Earth | None) -> dict[str, list[float]]:
    """Return the parameters of compasses that a scenario's place and year imply; none without a year.

    Raises ScenarioError in the blackout zone, MissingExtraError without pygeomag.
    """
    if earth is None or earth.magnetic_year is None:
        return {}
    declination_deg, inclination_deg, horizontal_ut, field_ut = _field(
        earth.latitude_deg, earth.longitude_deg, earth.magnetic_year
    )
    if horizontal_ut < LEAST_HORIZONTAL_UT:
        raise ScenarioError(
            f"earth.magnetic_year: the field's horizontal part is {horizontal_ut:.2f} uT here: compasses need "
            f"{LEAST_HORIZONTAL_UT:g} uT or more"
        )
    return {"declination_deg": [declination_deg], "inclination_deg": [inclination_deg], "field_ut": [field_ut]}


@cache
def _field(latitude_deg: float, longitude_deg: float, year: float) -> tuple[float, float, float, float]:
    need_extra("pygeomag", "earth.magnetic_year")
    from pygeomag import GeoMag

    model = GeoMag(coefficients_file=f"wmm/WMM_{2020 if year < NEXT_MODEL else 2025}.COF")
    found = model.calculate(glat=latitude_deg, glon=longitude_deg, alt=0.0, time=year)
    return float(found.d), float(found.i), 1e-3 * float(found.h), 1e-3 * float(found.f)
