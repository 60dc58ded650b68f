"""A scenario's wind and a vehicle's windage as core objects."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.hull import rigid_body
from uwsim.scenario.build.scale import require_floats
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.wind import Wind

Array = NDArray[np.float64]
REFERENCE_M = 10.0
LEAST_HZ, MOST_HZ = 1.0 / 600.0, 0.5
"""The range of the spectra, for which ISO 19901-1 states its own."""
HARMONICS = 120


def npd_spectrum(frequency_hz: Array, speed_m_s: float) -> Array:
    """Return the density (n,) [m2/s2/Hz] of gusts 10 m above the water: ISO 19901-1:2005, equation A.7.4-5."""
    reduced = 172.0 * frequency_hz * (speed_m_s / 10.0) ** -0.75
    n = 0.468
    return np.asarray(320.0 * (speed_m_s / 10.0) ** 2 / (1.0 + reduced**n) ** (5.0 / (3.0 * n)))


def davenport_spectrum(frequency_hz: Array, speed_m_s: float, surface_drag: float) -> Array:
    """Return the density (n,) [m2/s2/Hz]: Davenport 1961, f S = 4 k U^2 x^2 / (1 + x^2)^(4/3), x = 1200 m f / U.

    Its integral is 6 k U^2.
    """
    x = 1200.0 * frequency_hz / speed_m_s
    return np.asarray(4.0 * surface_drag * speed_m_s**2 * x**2 / (1.0 + x**2) ** (4.0 / 3.0) / frequency_hz)


def gusts(wind: Wind, seed: int) -> Array:
    """Return amplitude [m/s], angular frequency [rad/s] and phase [rad] of harmonics, (n, 3); n is 0 without gusts.

    Their frequencies are drawn within bands of equal ratio, so that the gusts do not repeat.
    """
    if wind.gusts is None or wind.speed_m_s == 0.0:
        return np.zeros((0, 3))
    spectrum: Callable[[Array], Array] = (
        (lambda f: npd_spectrum(f, wind.speed_m_s))
        if wind.gusts == "npd"
        else (lambda f: davenport_spectrum(f, wind.speed_m_s, wind.surface_drag))
    )
    random = np.random.default_rng([seed, 0x77696E64])
    edges = np.geomspace(LEAST_HZ, MOST_HZ, HARMONICS + 1)
    frequency = edges[:-1] * (edges[1:] / edges[:-1]) ** random.uniform(size=HARMONICS)
    amplitude = np.sqrt(2.0 * spectrum(frequency) * frequency * math.log(edges[1] / edges[0]))
    phase = random.uniform(0.0, 2.0 * math.pi, HARMONICS)
    return np.column_stack([amplitude, 2.0 * math.pi * frequency, phase])


def set_wind(spec: _core.SimulationSpec, scenario: Scenario) -> None:
    """Set the wind of the core's simulation, if the scenario has one."""
    if scenario.wind is not None:
        wind = scenario.wind
        spec.set_wind(wind.speed_m_s, math.radians(wind.heading_deg), gusts(wind, scenario.seed))


def windage(model: VehicleModel, density_kg_m3: float) -> _core.Windage | None:
    """Return what a vehicle offers the wind. Raises ScenarioError if it does not float."""
    given = model.windage
    if given is None:
        return None
    body = rigid_body(model, density_kg_m3)
    require_floats("windage", body.mass_kg, body.volume_m3, density_kg_m3)
    made = _core.Windage()
    for key in ("frontal_area_m2", "lateral_area_m2", "length_m", "height_m", "surge", "sway", "yaw"):
        setattr(made, key, getattr(given, key))
    # The profile V = V_10 (h / 10 m)^(1/7): Bretschneider 1969, in Fossen 2011, sec. 8.1.
    made.speed_share = (given.height_m / REFERENCE_M) ** (1.0 / 7.0)
    made.dry_volume_m3 = body.volume_m3 - body.mass_kg / density_kg_m3
    return made
