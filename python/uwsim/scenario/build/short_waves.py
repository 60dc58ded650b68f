"""Finds vehicles that float in waves which the model does not follow: short ones, since a hull makes none itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim import _core
from uwsim.scenario.build.hull import rigid_body, vehicle_hull
from uwsim.scenario.build.start_pose import start_pose
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle_entry import VehicleEntry

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
