"""Compares daylight with SPCTRAL2 (Bird 1984, Solar Energy 32:461) in pvlib: clear sky, the same haze, 3 mm of ozone.

uwsim's model has no ozone, which absorbs orange and green light, so it is brighter by what the sun's path loses there:
at 600 nm 16 % for a sun at 15 degrees, 34 % at 8 degrees. The comparison is therefore limited to higher suns.
"""

from __future__ import annotations

import numpy as np
import pvlib

from uwsim import _core
from uwsim.evidence.validate.check import Check, along
from uwsim.evidence.validate.peers import group

BANDS_NM = np.array([600.0, 550.0, 450.0])
SUNS_DEG = (80.0, 60.0, 45.0, 30.0)
WATER_INDEX, SKY_REFLECTED = 1.333, 0.066
HAZE, HAZE_EXPONENT = 0.08, 1.3  # optical depth at 550 nm, and its Angstrom exponent


def checks() -> list[Check]:
    """Return a check for each elevation of the sun: the irradiance on a level surface just below flat water."""
    found = []
    for sun_deg in SUNS_DEG:
        optics = _core.Optics(_core.WaterOptics.jerlov("I"), np.radians(sun_deg), 0.0, 0.0, 0.0, 0.0, 0.0)
        got = np.ravel(optics.level_irradiance_below())
        name = f"sun at {sun_deg:g} deg: level irradiance below the surface, of the sun's in space"
        found.append(along(group("daylight"), name, _expected(sun_deg), got, float(got.max()), 0.07))
    return found


def _expected(sun_deg: float) -> np.ndarray:
    zenith_deg = 90.0 - sun_deg
    sky = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith_deg,
        aoi=zenith_deg,
        surface_tilt=0.0,
        ground_albedo=0.06,
        surface_pressure=101325.0,
        relative_airmass=pvlib.atmosphere.get_relative_airmass(zenith_deg, "kastenyoung1989"),
        precipitable_water=1.5,
        ozone=0.3,
        aerosol_turbidity_500nm=HAZE * (550 / 500) ** HAZE_EXPONENT,
        alpha=HAZE_EXPONENT,
        dayofyear=94,
    )
    beam, diffuse, space = (
        np.interp(BANDS_NM, sky["wavelength"], np.ravel(sky[key])) for key in ("dni", "dhi", "dni_extra")
    )
    cosine = np.cos(np.radians(zenith_deg))
    below = np.sqrt(1.0 - (1.0 - cosine**2) / WATER_INDEX**2)  # Snell's law
    across = (cosine - WATER_INDEX * below) / (cosine + WATER_INDEX * below)
    along_plane = (WATER_INDEX * cosine - below) / (WATER_INDEX * cosine + below)
    reflected = 0.5 * (across**2 + along_plane**2)
    return np.asarray(((1.0 - reflected) * cosine * beam + (1.0 - SKY_REFLECTED) * diffuse) / space)
