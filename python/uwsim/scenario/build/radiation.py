"""A floating hull's table of radiation and diffraction as a core object, compared with the hull, about its origin."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.hull import RigidBody
from uwsim.scenario.build.radiation_drift import HORIZONTAL, own_drift
from uwsim.scenario.build.radiation_fit import Fit, fitted
from uwsim.scenario.build.radiation_hull import (
    UprightHull,
    floating_upright,
    pressure_forces,
    require_same_hull,
)
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.read.radiation_file import read_radiation
from uwsim.scenario.read.radiation_table import RadiationTable, broken_file

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ASYMMETRY, ENERGY_SOURCE, WORST_FIT = 0.05, 0.02, 0.1
"""Largest share of the table's largest value: asymmetry of a matrix, negative damping, error of the fit."""
WIDEST_GAP_RAD = np.radians(46.0)
"""Between headings of a table, which are joined by trigonometric series."""
FREQUENCIES, HEADINGS = 160, 72
"""The core's grid, in which it interpolates."""


@dataclass(frozen=True)
class RadiationReport:
    """The quality of a fit: its sections, its largest error as a share, the table's frequencies, and mean drift."""

    sections: int
    error: float
    least_rad_s: float
    most_rad_s: float
    water_depth_m: float
    drifts: bool


def radiation(
    path: Path,
    body: RigidBody,
    vertices_m: Array,
    triangles: NDArray[np.uint32],
    density_kg_m3: float,
) -> _core.Radiation:
    """Return the waves that a hull makes and deflects, from its table.

    body: with which the hull floats upright in water of this density, as the table has it. Raises ScenarioError for a
    table of another hull, and one that no passive fit follows.
    """
    return _made(path, body, vertices_m, triangles, density_kg_m3)[0]


def radiation_report(
    path: Path,
    body: RigidBody,
    vertices_m: Array,
    triangles: NDArray[np.uint32],
    density_kg_m3: float,
) -> RadiationReport:
    """Return the quality of the same. Raises ScenarioError."""
    return _made(path, body, vertices_m, triangles, density_kg_m3)[1]


def _made(
    path: Path,
    body: RigidBody,
    vertices_m: Array,
    triangles: NDArray[np.uint32],
    density_kg_m3: float,
) -> tuple[_core.Radiation, RadiationReport]:
    table = _read(path, (path.stat().st_mtime_ns, path.stat().st_size))
    hull = floating_upright(path, body.mass_kg, vertices_m, triangles, density_kg_m3)
    require_same_hull(path, table, hull, body.mass_kg, density_kg_m3)
    to_origin = _turned_about_origin(table, hull)
    denser = density_kg_m3 / table.density_kg_m3
    added, damping, infinite = (
        denser * np.einsum("ki,...kl,lj->...ij", to_origin, matrix, to_origin)
        for matrix in (table.added_mass, table.damping, table.added_mass_infinite)
    )
    for name, matrix in (("added_mass", added), ("radiation_damping", damping)):
        _require_symmetric(path, name, matrix, hull.half_length_m)
    added, damping, infinite = (0.5 * (each + np.swapaxes(each, -1, -2)) for each in (added, damping, infinite))
    _require_damping(path, table.omega_rad_s, damping, hull.half_length_m)
    memory = damping + 1j * table.omega_rad_s[:, None, None] * (added - infinite)
    fit = _fit(path, table.omega_rad_s, memory, infinite, hull.half_length_m)
    omega = np.linspace(table.omega_rad_s[0], table.omega_rad_s[-1], FREQUENCIES)
    forces = denser * _beyond_pressure(path, table, hull, omega) @ to_origin
    sections = list(zip(*fit[:4], strict=True))
    numbers = (infinite, sections, forces, omega[0], omega[-1], hull.wet_volume_m3)
    made = _core.Radiation(*numbers)
    if table.drift is not None:
        drift = denser * _around(path, table, _about_origin(table, table.drift), omega)
        own = _own_drift(table, hull, body, made, density_kg_m3, omega, (*fit[:4], forces))
        made = _core.Radiation(*numbers, drift - _around(path, table, own))
    drifts = table.drift is not None
    return made, RadiationReport(len(sections), fit.error, omega[0], omega[-1], table.water_depth_m, drifts)


@lru_cache(maxsize=16)
def _read(path: Path, version: tuple[int, int]) -> RadiationTable:
    """Read the table. version: identifies the state of the file, to keep the cache current."""
    return read_radiation(path)


def _turned_about_origin(table: RadiationTable, hull: UprightHull) -> Array:
    """Return the matrix (6, 6) from motions about the body's origin to those about the table's centre."""
    x, y, z = np.add(table.centre_m, (0.0, 0.0, hull.waterline_m))
    matrix = np.eye(6)
    matrix[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return matrix


def _in_lengths(matrices: Array, half_length_m: float) -> Array:
    units = np.array([1.0, 1.0, 1.0, half_length_m, half_length_m, half_length_m])
    return np.asarray(matrices / np.multiply.outer(units, units), np.float64)


def _require_symmetric(path: Path, name: str, matrices: Array, half_length_m: float) -> None:
    scaled = _in_lengths(matrices, half_length_m)
    off = np.abs(scaled - np.swapaxes(scaled, -1, -2)).max() / np.abs(scaled).max()
    if off > ASYMMETRY:
        raise broken_file(
            path, f"{name} is asymmetric by {off:.0%} of its largest value: must be within {ASYMMETRY:.0%}"
        )


def _require_damping(path: Path, omega_rad_s: Array, damping: Array, half_length_m: float) -> None:
    lowest = np.linalg.eigvalsh(_in_lengths(damping, half_length_m))
    share = lowest[:, 0] / lowest.max()
    worst = int(share.argmin())
    if share[worst] < -ENERGY_SOURCE:
        raise broken_file(
            path,
            f"radiation_damping at {omega_rad_s[worst]:.3g} rad/s adds energy, by {-share[worst]:.0%} of the largest "
            f"damping: must be positive semi-definite within {ENERGY_SOURCE:.0%}; irregular frequencies need a lid",
        )


def _fit(path: Path, omega_rad_s: Array, memory: Complex, added_mass_infinite: Array, half_length_m: float) -> Fit:
    def make() -> tuple[Array, ...]:
        return tuple(np.asarray(part) for part in fitted(omega_rad_s, memory, added_mass_infinite, half_length_m))

    stored = cached_arrays(make, "radiation", omega_rad_s, memory, added_mass_infinite, half_length_m)
    by_speed, by_place, omega, ratio, error = (np.asarray(part, np.float64) for part in stored)
    fit = Fit(by_speed, by_place, omega, ratio, float(error[()]))
    if fit.error > WORST_FIT:
        raise broken_file(
            path,
            f"the best passive fit is wrong by {fit.error:.0%} of the largest value, must be at most {WORST_FIT:.0%}: "
            "its added mass, infinite-frequency added mass and damping do not belong together, or its frequencies are "
            "too few",
        )
    return fit


def _beyond_pressure(path: Path, table: RadiationTable, hull: UprightHull, omega_rad_s: Array) -> Complex:
    """Return the waves' force that a step lacks, (DIVISIONS, frequencies, HEADINGS, 6), about the table's centre.

    That is diffraction, and what the pressure on the hull's slices leaves out of that on its panels.
    """

    def make() -> tuple[Array, ...]:
        force = pressure_forces(table, hull)
        return force.real, force.imag

    own = cached_arrays(make, "radiation_pressure", hull.vertices_m, hull.triangles, hull.waterline_m,
                        table.omega_rad_s, table.heading_rad, table.centre_m, table.density_kg_m3, table.gravity_m_s2,
                        table.water_depth_m)  # fmt: skip
    beyond = table.exciting - (np.asarray(own[0], np.complex128) + 1j * np.asarray(own[1], np.complex128))
    return np.asarray(_around(path, table, beyond, omega_rad_s), np.complex128)


def _about_origin(table: RadiationTable, drift: Array) -> Array:
    """Return the mean drift, (1, frequencies, headings, 3), with the moment about the origin."""
    surge, sway, yaw = np.moveaxis(drift, -1, 0)
    return np.stack([surge, sway, yaw + table.centre_m[0] * sway - table.centre_m[1] * surge], axis=-1)[None]


def _own_drift(
    table: RadiationTable, hull: UprightHull, body: RigidBody, model: _core.Radiation, density_kg_m3: float,
    omega_rad_s: Array, numbers: tuple[NDArray[Any], ...],
) -> Array:  # fmt: skip
    """Return own_drift, which is slow, from the cache if it is there. numbers: those of the model."""

    def make() -> tuple[Array, ...]:
        return (own_drift(table, hull, body, model, density_kg_m3, omega_rad_s),)

    parts = (*numbers[:-1], numbers[-1].real, numbers[-1].imag, model.added_mass)
    stored = cached_arrays(make, "radiation_drift", hull.vertices_m, hull.triangles, hull.waterline_m, *parts,
                           body.mass_kg, body.centre_of_mass_m, body.inertia_kg_m2, density_kg_m3, table.gravity_m_s2,
                           table.water_depth_m, table.heading_rad, omega_rad_s)  # fmt: skip
    return np.asarray(stored[0], np.float64)


def _around(path: Path, table: RadiationTable, values: NDArray[Any], omega_rad_s: Array | None = None) -> NDArray[Any]:
    """Return values (..., frequencies, headings, axes) at HEADINGS, and at other frequencies than the table's."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    heading, given = _all_around(path, table, values)
    closed = np.concatenate([given, given[:, :, :1]], axis=2)
    around = CubicSpline(np.append(heading, heading[0] + 2.0 * np.pi), closed, axis=2, bc_type="periodic")
    turned = np.asarray(around(np.arange(HEADINGS) * 2.0 * np.pi / HEADINGS))
    if omega_rad_s is None:
        return turned
    series = CubicSpline if values.shape[-1] == 6 else PchipInterpolator  # drift has peaks, beside which it would swing
    return np.asarray(series(table.omega_rad_s, turned, axis=1)(omega_rad_s))


def _all_around(path: Path, table: RadiationTable, values: NDArray[Any]) -> tuple[Array, NDArray[Any]]:
    """Return headings in [0, 2 pi) and the values: a table for one side of a hull is mirrored."""
    heading = np.mod(table.heading_rad, 2.0 * np.pi)
    order = np.argsort(heading)
    heading, values = heading[order], values[:, :, order]
    if np.diff(heading).min(initial=1.0) < 1e-6:  # 0 and 360 degrees
        kept = np.append(True, np.diff(heading) > 1e-6)
        heading, values = heading[kept], values[:, :, kept]
    if heading.max() <= np.pi + 1e-6 and _has_two_equal_sides(table):
        inner = (heading > 1e-6) & (heading < np.pi - 1e-6)
        mirror = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])[list(HORIZONTAL) if values.shape[-1] == 3 else slice(6)]
        heading = np.concatenate([heading, 2.0 * np.pi - heading[inner][::-1]])
        values = np.concatenate([values, (mirror * values[:, :, inner])[:, :, ::-1]], axis=2)
    gap = np.diff(np.append(heading, heading[0] + 2.0 * np.pi)).max()
    if gap > WIDEST_GAP_RAD:
        raise broken_file(
            path,
            f"wave_direction leaves a gap of {np.degrees(gap):.0f} deg: must be at most "
            f"{np.degrees(WIDEST_GAP_RAD):.0f} deg, all around or, for a hull with two equal sides, from 0 to 180 deg",
        )
    return heading, values


def _has_two_equal_sides(table: RadiationTable) -> bool:
    """Return true if motions along the plane of symmetry and across it do not couple."""
    mixed = np.abs(_in_lengths(table.added_mass, 1.0))[:, ::2, 1::2].max()
    return bool(abs(table.centre_m[1]) < 1e-6 and mixed < 1e-3 * np.abs(table.added_mass).max())
