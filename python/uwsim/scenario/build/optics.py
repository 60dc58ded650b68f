"""A scenario's optics as core objects: water, sun, wind, particles and turbulence."""

from __future__ import annotations

import numpy as np

from uwsim import _core
from uwsim.scenario.spec.optics import Optics


def core_optics(optics: Optics) -> _core.Optics:
    """Return the core's optics."""
    return _core.Optics(
        optics.water,
        float(np.radians(optics.sun_elevation_deg)),
        float(np.radians(optics.sun_azimuth_deg)),
        optics.wind_m_s,
        float(np.radians(optics.wind_heading_deg)),
        optics.particles_per_m3,
        optics.turbulence_k,
        np.inf if optics.fetch_m is None else optics.fetch_m,
    )
