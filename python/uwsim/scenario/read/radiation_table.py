"""The table of a floating hull's hydrodynamics that files of panel codes contain."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.errors import ScenarioError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MAX_VALUES = 50_000_000
"""The largest array of a file."""
LEAST_FREQUENCIES = 4


@dataclass(frozen=True, eq=False)
class RadiationTable:
    """A hull's hydrodynamics by frequency, in the file's frame: x forward, z up from the still surface.

    omega_rad_s: (n,), ascending. added_mass, damping: (n, 6, 6) about centre_m [kg, kg m, kg m2 and per second].
    added_mass_infinite: (6, 6). heading_rad: (m,), ascending, of the waves' travel. exciting: complex (n, m, 6), the
    whole force on the fixed hull per metre of amplitude, of exp(-i omega t). froude_krylov: the part of the undisturbed
    waves' pressure, None if not given. drift: (n, m, 3), the mean force in surge and sway [N/m2] and moment in yaw
    about centre_m [N/m] on the free hull per squared metre of amplitude, None if not given. centre_m: (3,), the point
    about which the hull turns. displaced_kg: mass of the displaced water, None if not given. water_depth_m: may be
    infinite. of_any_density: values are in proportion to the water's density, of which density_kg_m3 is an example.
    """

    omega_rad_s: Array
    added_mass: Array
    damping: Array
    added_mass_infinite: Array
    heading_rad: Array
    exciting: Complex
    froude_krylov: Complex | None
    centre_m: Array
    density_kg_m3: float
    gravity_m_s2: float
    displaced_kg: float | None
    water_depth_m: float
    drift: Array | None = None
    of_any_density: bool = False


def broken_file(path: Path, text: str) -> ScenarioError:
    """Return the error of a file."""
    return ScenarioError(f"radiation '{path}': {text}", at=("radiation",))


def table_of(
    path: Path,
    omega_rad_s: Array,
    matrices: tuple[Array, Array],
    heading_rad: Array,
    forces: tuple[Complex, Complex | None],
    drift: Array | None = None,
    **others: Any,
) -> RadiationTable:
    """Return a table in ascending order.

    omega_rad_s: (n,), with infinity; rows at 0 are left out. matrices: added mass and damping, (n, 6, 6). forces: the
    whole, and the undisturbed waves' part, (n, m, 6), and drift, (n, m, 3): at infinity not used. Raises ScenarioError.
    """
    finite, infinite = np.isfinite(omega_rad_s) & (omega_rad_s > 0), np.isposinf(omega_rad_s)
    if not infinite.any():
        raise broken_file(
            path, "added mass at infinite frequency missing: compute it with omega = inf beside the others"
        )
    if finite.sum() < LEAST_FREQUENCIES:
        raise broken_file(path, f"omega has {finite.sum()} finite frequencies: must be at least {LEAST_FREQUENCIES}")
    order = np.flatnonzero(finite)[np.argsort(omega_rad_s[finite])]
    turn = np.argsort(heading_rad)
    if np.any(np.diff(omega_rad_s[order]) <= 0) or np.any(np.diff(heading_rad[turn]) <= 0):
        raise broken_file(path, "omega and wave_direction must not repeat values")
    whole, pressure = forces
    table = RadiationTable(
        omega_rad_s=omega_rad_s[order],
        added_mass=matrices[0][order],
        damping=matrices[1][order],
        added_mass_infinite=matrices[0][np.flatnonzero(infinite)[0]],
        heading_rad=heading_rad[turn],
        exciting=whole[order][:, turn],
        froude_krylov=None if pressure is None else pressure[order][:, turn],
        drift=None if drift is None else drift[order][:, turn],
        **others,
    )
    for field in fields(table):
        value = getattr(table, field.name)
        if isinstance(value, np.ndarray) and not np.all(np.isfinite(value)):
            raise broken_file(path, f"{field.name} must be finite")
    return table
