"""A scenario's optics as core objects: water, sun, wind, particles and turbulence."""

from __future__ import annotations

import numpy as np

from uwsim import _core
from uwsim.scenario.spec.optics import Optics


def core_optics(optics: Optics) -> _core.Optics:
    """Return the core's optics."""
    return _core.Optics(
        _water(optics),
        float(np.radians(optics.sun_elevation_deg)),
        float(np.radians(optics.sun_azimuth_deg)),
        optics.wind_m_s,
        float(np.radians(optics.wind_heading_deg)),
        optics.particles_per_m3,
        optics.turbulence_k,
        1e-3 * optics.forward_scatter_mrad,
    )


def _water(optics: Optics) -> _core.WaterOptics:
    """Return the water, scaled to the visibility that is set, if one is."""
    own = optics.coefficients
    if own is None:
        water = _core.WaterOptics.jerlov(optics.jerlov)
    else:
        water = _core.WaterOptics(own.diffuse_attenuation, own.absorption, own.scattering)
    if optics.visibility_m is None:
        return water
    share = visibility_m(water) / optics.visibility_m
    return _core.WaterOptics(share * water.diffuse_attenuation, share * water.absorption, share * water.scattering)


def visibility_m(water: _core.WaterOptics) -> float:
    """Return the distance at which a diver can see a dark object horizontally: 4.8 / c, with c [1/m] at 550 nm.

    Zaneveld and Pegau 2003, "Robust underwater visibility parameter", Optics Express 11, which gives the factor for 532
    nm.
    """
    return 4.8 / float(water.beam_attenuation[1])
