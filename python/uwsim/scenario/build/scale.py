"""Checks that mesh scales are plausible: a mesh in millimetres, read as metres, is a thousand times too large."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.scenario.build.terrain import Terrain
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.vehicle import DENSITIES_KG_M3, VOLUMES_M3

UNITS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "feet": 0.3048}
"""Units in which meshes are drawn, in metres."""
LENGTHS_M = (0.2, 15.0)
"""Lengths of typical vehicles, used to guess a mesh's unit."""
METRES = {"metres": 1.0, **UNITS}
HUGE_M = 50.0
"""Few vehicles are longer than this; a greater length suggests another unit."""
HUGE_OBSTACLE_M = 1000.0
TERRAINS_ACROSS = 10.0
"""Maximum length of an obstacle relative to the terrain: a quay may extend beyond a test basin."""


def size_text(size_m: Floats) -> str:
    """Return text such as `1.2 x 0.8 x 0.7 m`."""
    return " x ".join(f"{side:.4g}" for side in size_m) + " m"


def likely_units(length: float) -> list[str]:
    """Return the units of METRES in which a vehicle may be this long; the first is the likeliest."""
    low, high = LENGTHS_M
    return [unit for unit, metres in METRES.items() if low <= length * metres <= high]


def question_of_factor(factor: float, mesh_scale: float) -> str:
    """Return the end of a message, "is its mesh in mm?", if a unit explains this factor in lengths, else ""."""
    unit = next((unit for unit, metres in UNITS.items() if 0.9 <= factor / metres <= 1.1), None)
    return "" if unit is None else _question([unit], mesh_scale)


def require_plausible_volume(
    name: str, volume_m3: float, size_m: Floats, mesh_scale: float, mass_kg: float | None
) -> None:
    """Raise ScenarioError for a hull, with extents size_m (3,), whose volume is implausible for a vehicle.

    mass_kg: the vehicle's mass, if known: the best evidence for the mesh unit.
    """
    low, high = VOLUMES_M3
    if low <= volume_m3 <= high:
        return
    if mass_kg is not None:
        hint = _of_density(mass_kg / volume_m3, mesh_scale)
    else:
        hint = _of_size(float(size_m.max()), mesh_scale) if volume_m3 > high else _too_small(mesh_scale)
    raise ScenarioError(
        f"vehicle '{name}': its hull of {size_text(size_m)} encloses {volume_m3:.4g} m3: must be in "
        f"[{low:g}, {high:g}] m3{hint}",
        at=("mesh",),
    )


def require_plausible_density(name: str, mass_kg: float, volume_m3: float, mesh_scale: float, what: str) -> None:
    """Raise ScenarioError for a mass that does not match the hull. what: what the mass includes, for the message."""
    density = mass_kg / volume_m3
    low, high = DENSITIES_KG_M3
    if low <= density <= high:
        return
    raise ScenarioError(
        f"vehicle '{name}': {what} of {mass_kg:.4g} kg in a hull of {volume_m3:.4g} m3 makes {density:.4g} kg/m3: must "
        f"be in [{low:g}, {high:g}] kg/m3{_of_density(density, mesh_scale)}",
        at=("mesh",),
    )


def require_floats(key: str, mass_kg: float, volume_m3: float, density_kg_m3: float) -> None:
    """Raise ScenarioError unless a hull floats, which this key of a vehicle's file needs."""
    if mass_kg < density_kg_m3 * volume_m3:
        return
    raise ScenarioError(
        f"{key}: is only for a hull that floats: {mass_kg:.4g} kg is at least the {density_kg_m3 * volume_m3:.4g} kg "
        "of water that it displaces",
        at=(key,),
    )


def require_fits(name: str, hull_m: Floats, terrain: Terrain, mesh_scale: float) -> None:
    """Raise ScenarioError for a hull, vertices (n, 3), longer than the terrain or taller than the water is deep.

    terrain: the whole terrain, even if only a window of it is built.
    """
    size_m = np.ptp(hull_m, axis=0)
    longest, deepest_m = float(size_m.max()), -terrain.lowest_m
    x0, y0, x1, y1 = terrain.extent_m
    if longest > max(x1 - x0, y1 - y0):
        rule = f"must be shorter than the terrain, {x1 - x0:g} x {y1 - y0:g} m"
    elif longest > HUGE_M and float(size_m.min()) > deepest_m:
        rule = f"must have room in the water, which is {deepest_m:g} m deep at most"
    else:
        return
    hint = _of_size(longest, mesh_scale)
    raise ScenarioError(f"vehicle '{name}': its hull of {size_text(size_m)} {rule}{hint}", at=("mesh",))


def require_solid_fits(name: str, vertices_m: Floats, terrain: Terrain) -> None:
    """Raise ScenarioError for an obstacle or station mesh that is far larger than the terrain."""
    size_m = np.ptp(vertices_m, axis=0)
    x0, y0, x1, y1 = terrain.extent_m
    most_m = max(HUGE_OBSTACLE_M, TERRAINS_ACROSS * max(x1 - x0, y1 - y0))
    if float(size_m.max()) > most_m:
        raise ScenarioError(
            f"'{name}': its mesh of {size_text(size_m)} must be at most {most_m:g} m long in a terrain of "
            f"{x1 - x0:g} x {y1 - y0:g} m: is it in millimetres? scale: 0.001"
        )


def _of_size(longest_m: float, mesh_scale: float) -> str:
    """Return such a question for a hull that is too long, or an empty string if no unit explains its length."""
    units = likely_units(longest_m)
    return "" if longest_m <= HUGE_M or not units else _question(units, mesh_scale)


def _of_density(density_kg_m3: float, mesh_scale: float) -> str:
    """Return such a question for the unit with the most plausible density (closest to water's), or an empty string."""
    if density_kg_m3 > DENSITIES_KG_M3[1]:
        return _too_small(mesh_scale) if mesh_scale != 1.0 else ": is the mass in kg and the mesh in metres?"
    water, (low, high) = 1000.0, DENSITIES_KG_M3
    unit, metres = min(UNITS.items(), key=lambda item: abs(math.log(density_kg_m3 / item[1] ** 3 / water)))
    return _question([unit], mesh_scale) if low <= density_kg_m3 / metres**3 <= high else ""


def _question(units: Sequence[str], mesh_scale: float) -> str:
    scales = " or ".join(f"{mesh_scale * UNITS[unit]:g}" for unit in units)
    return f": is its mesh in {' or '.join(units)}? mesh_scale: {scales}"


def _too_small(mesh_scale: float) -> str:
    return f": is mesh_scale = {mesh_scale:g} too small?"
