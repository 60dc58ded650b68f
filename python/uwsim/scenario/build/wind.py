"""A scenario's wind and a vehicle's windage as core objects, and waves too short for the model of a floating hull."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.build.scale import require_floats
from uwsim.scenario.build.station import start_pose
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.scenario.spec.water_parts import Wind

REFERENCE_M = 10.0
LEAST_HZ, MOST_HZ = 1.0 / 600.0, 0.5
"""The range of the spectra, for which ISO 19901-1 states its own."""
HARMONICS = 120


def npd_spectrum(frequency_hz: Floats, speed_m_s: float) -> Floats:
    """Return the density (n,) [m2/s2/Hz] of gusts 10 m above the water: ISO 19901-1:2005, equation A.7.4-5."""
    reduced = 172.0 * frequency_hz * (speed_m_s / 10.0) ** -0.75
    n = 0.468
    return np.asarray(320.0 * (speed_m_s / 10.0) ** 2 / (1.0 + reduced**n) ** (5.0 / (3.0 * n)))


def davenport_spectrum(frequency_hz: Floats, speed_m_s: float, surface_drag: float) -> Floats:
    """Return the density (n,) [m2/s2/Hz]: Davenport 1961, f S = 4 k U^2 x^2 / (1 + x^2)^(4/3), x = 1200 m f / U.

    Its integral is 6 k U^2.
    """
    x = 1200.0 * frequency_hz / speed_m_s
    return np.asarray(4.0 * surface_drag * speed_m_s**2 * x**2 / (1.0 + x**2) ** (4.0 / 3.0) / frequency_hz)


def gusts(wind: Wind, seed: int) -> Floats:
    """Return amplitude [m/s], angular frequency [rad/s] and phase [rad] of harmonics, (n, 3); n is 0 without gusts.

    Their frequencies are drawn within bands of equal ratio, so that the gusts do not repeat.
    """
    if wind.gusts is None or wind.speed_m_s == 0.0:
        return np.zeros((0, 3))
    spectrum: Callable[[Floats], Floats] = (
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


LENGTHS = 5.0
"""Waves along a floating hull must be this many times as long as the hull (docs/inside/theory.md)."""
ENERGY_SHARE = 0.1
"""Share of a sea's energy in shorter waves beyond which a warning is given."""
RISING_SHARE = 0.03
"""Operators leave a vehicle that dives slightly buoyant, up to this share of its weight."""


class ShortWavesWarning(UserWarning):
    """Issued for a vehicle that floats in waves that are short compared with its hull."""


def short_wave_warning(scenario: Scenario, index: int, water: _core.Water, net_buoyancy_n: float) -> str | None:
    """Return a sentence if a vehicle floats in too short waves, else None.

    It floats if its hull reaches the water's surface where it starts or is docked, or if it is too buoyant to be
    balanced for diving, so that it rises to the surface whenever nothing drives it down. net_buoyancy_n: deep in still
    water.
    """
    entry = scenario.vehicles[index]
    if water.waves is None:
        return None
    if _is_afloat(scenario, entry, water.waves):
        where = "is docked at the surface" if entry.start is None else "starts at the surface"
    elif _rises(entry, water, net_buoyancy_n):
        where = "rises to the surface"
    else:
        return None
    length_m = hull_length_m(entry.model)
    share = energy_share(water.waves, LENGTHS * length_m, water.gravity_m_s2)
    if share <= ENERGY_SHARE:
        return None
    return (
        f"{scenario.source_file.line_prefix('vehicles', index)}vehicle '{entry.name}' {where}, where "
        f"{100.0 * share:.0f} % of the waves' energy is in waves shorter than {LENGTHS:g} of its lengths "
        f"({length_m:.2g} m): its heave and pitch there may be wrong by several times, since the waves that a hull "
        "makes are not modelled (docs/inside/theory.md)"
    )


def hull_length_m(model: Any) -> float:
    """Return the longer of a hull's extents along and across the vehicle."""
    return float(np.ptp(np.asarray(vehicle_hull(model)[0])[:, :2], axis=0).max())


def energy_share(waves: _core.Waves, length_m: float, gravity_m_s2: float) -> float:
    """Return the share of the energy in waves that are shorter than a length."""
    amplitude_m, omega_rad_s = waves.components.T[:2]
    number_rad_m = 2.0 * np.pi / length_m
    limit_rad_s = np.sqrt(gravity_m_s2 * number_rad_m * np.tanh(number_rad_m * waves.depth_m))
    energy = amplitude_m**2
    return float(energy[omega_rad_s > limit_rad_s].sum() / energy.sum()) if energy.any() else 0.0


def _is_afloat(scenario: Scenario, entry: VehicleEntry, waves: _core.Waves) -> bool:
    position_m, _ = start_pose(scenario, entry)
    height_m = np.asarray(vehicle_hull(entry.model)[0])[:, 2] + position_m[2]
    reach_m = 0.5 * waves.significant_height_m
    return bool(height_m.min() < reach_m and height_m.max() > -reach_m)


def _rises(entry: VehicleEntry, water: _core.Water, net_buoyancy_n: float) -> bool:
    displaced_kg = float(water.density_at_kg_m3(0.0)) * rigid_body(entry.model, 1000.0).volume_m3
    weight_n = displaced_kg * water.gravity_m_s2 - net_buoyancy_n
    return net_buoyancy_n > RISING_SHARE * weight_n
