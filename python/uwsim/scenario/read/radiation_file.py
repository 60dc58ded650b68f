"""Reads the table of a floating hull's hydrodynamics that Capytaine writes: its dataset as NetCDF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import MissingExtraError
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.netcdf_file import NetcdfVariable, NotNetcdfError, read_netcdf

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
MATRICES, FORCES = ("added_mass", "radiation_damping"), ("diffraction_force", "Froude_Krylov_force")
PAIR = "complex"
"""The axis of real and imaginary parts."""


@dataclass(frozen=True, eq=False)
class RadiationTable:
    """A hull's hydrodynamics by frequency, in the file's frame: x forward, z up from the still surface.

    omega_rad_s: (n,), ascending. added_mass, damping: (n, 6, 6) about centre_m [kg, kg m, kg m2 and per second].
    added_mass_infinite: (6, 6). heading_rad: (m,), ascending, of the waves' travel. diffraction, froude_krylov: complex
    (n, m, 6) per metre of amplitude, of exp(-i omega t). centre_m: (3,), the point about which the hull turns.
    displaced_kg: mass of the displaced water, None if not given. water_depth_m: may be infinite.
    """

    omega_rad_s: Array
    added_mass: Array
    damping: Array
    added_mass_infinite: Array
    heading_rad: Array
    diffraction: Complex
    froude_krylov: Complex
    centre_m: Array
    density_kg_m3: float
    gravity_m_s2: float
    displaced_kg: float | None
    water_depth_m: float


def read_radiation(path: Path) -> RadiationTable:
    """Read a table. Raises ScenarioError."""
    try:
        variables = read_netcdf(path, f"radiation '{path}'")
    except MissingExtraError:
        raise
    except NotNetcdfError as error:
        raise _broken(path, str(error)) from None
    except Exception as error:  # damaged files raise anything in both readers
        raise _broken(path, f"is not readable: {type(error).__name__}: {error}") from error
    return _Reader(path, variables).table()


def _broken(path: Path, text: str) -> ScenarioError:
    return ScenarioError(f"radiation '{path}': {text}", at=("radiation",))


class _Reader:
    """The variables of one file."""

    def __init__(self, path: Path, variables: dict[str, NetcdfVariable]) -> None:
        self._path, self._all = path, variables

    def table(self) -> RadiationTable:
        """Return the table. Raises ScenarioError."""
        missing = [name for name in (*MATRICES, *FORCES, "omega", "wave_direction") if name not in self._all]
        if missing:
            raise self._broken(f"{', '.join(missing)} missing: must be a dataset of Capytaine with radiation and waves")
        omega, heading = self._numbers("omega").ravel(), self._numbers("wave_direction").ravel()
        matrices = [self._matrices(name) for name in MATRICES]
        forces = [self._forces(name) for name in FORCES]
        finite, infinite = np.isfinite(omega) & (omega > 0), np.isposinf(omega)
        if not infinite.any():
            raise self._broken(
                "added mass at infinite frequency missing: compute it with omega = inf beside the others"
            )
        if finite.sum() < 4:
            raise self._broken(f"omega has {finite.sum()} finite frequencies: must be at least 4")
        order = np.flatnonzero(finite)[np.argsort(omega[finite])]
        turn = np.argsort(heading)
        if np.any(np.diff(omega[order]) <= 0) or np.any(np.diff(heading[turn]) <= 0):
            raise self._broken("omega and wave_direction must not repeat values")
        table = RadiationTable(
            omega_rad_s=omega[order],
            added_mass=matrices[0][order],
            damping=matrices[1][order],
            added_mass_infinite=matrices[0][np.flatnonzero(infinite)[0]],
            heading_rad=heading[turn],
            diffraction=forces[0][order][:, turn],
            froude_krylov=forces[1][order][:, turn],
            centre_m=self._vector("rotation_center"),
            density_kg_m3=self._scalar("rho", 0.0),
            gravity_m_s2=self._scalar("g", 0.0),
            displaced_kg=self._scalar("disp_mass", 0.0) if "disp_mass" in self._all else None,
            water_depth_m=self._scalar("water_depth", 0.0) if "water_depth" in self._all else np.inf,
        )
        if self._is_moving():
            raise self._broken("forward_speed must be 0 m/s: tables of a moving hull are not read")
        for name in ("added_mass", "damping", "added_mass_infinite", "diffraction", "froude_krylov", "centre_m"):
            if not np.all(np.isfinite(getattr(table, name))):
                raise self._broken(f"{name} must be finite")
        return table

    def _broken(self, text: str) -> ScenarioError:
        return _broken(self._path, text)

    def _numbers(self, name: str) -> Array:
        try:
            return np.asarray(self._all[name].values, np.float64)
        except (ValueError, TypeError):
            raise self._broken(f"{name} must be numbers") from None

    def _vector(self, name: str) -> Array:
        if name not in self._all or self._numbers(name).size != 3:
            raise self._broken(f"{name} missing: must be the point about which the hull turns, 3 values")
        return self._numbers(name).ravel()

    def _scalar(self, name: str, above: float) -> float:
        values = self._numbers(name) if name in self._all else np.array([])
        if values.size != 1 or not values.item() > above:
            raise self._broken(f"{name} must be one value above {above:g}")
        return float(values.item())

    def _is_moving(self) -> bool:
        return "forward_speed" in self._all and bool(np.any(self._numbers("forward_speed") != 0))

    def _in_order(self, name: str, wanted: tuple[str, ...], values: NDArray[Any]) -> NDArray[Any]:
        """Return the array with these axes; others, such as the water's depth, have one value."""
        axes = list(self._all[name].axes)
        for axis in reversed(range(len(axes))):
            if axes[axis] not in wanted:
                if values.shape[axis] != 1:
                    raise self._broken(f"{name} has {values.shape[axis]} values along {axes[axis]}: must be 1")
                values = values.squeeze(axis)
                axes.pop(axis)
        if sorted(axes) != sorted(wanted):
            raise self._broken(f"{name} has the axes {', '.join(axes)}: must be {', '.join(wanted)}")
        return np.moveaxis(values, [axes.index(each) for each in wanted], range(len(wanted)))

    def _matrices(self, name: str) -> Array:
        values = self._in_order(name, ("omega", "influenced_dof", "radiating_dof"), self._numbers(name))
        return values[:, self._dofs("influenced_dof")][:, :, self._dofs("radiating_dof")]

    def _forces(self, name: str) -> Complex:
        wanted = ("omega", "wave_direction", "influenced_dof")
        values = self._all[name].values
        if values.dtype.names is not None and len(values.dtype.names) == 2:  # HDF5's complex numbers
            real, imaginary = (np.asarray(values[part], np.float64) for part in values.dtype.names)
            both = self._in_order(name, wanted, real + 1j * imaginary)
            return np.asarray(both[:, :, self._dofs("influenced_dof")], np.complex128)
        if PAIR not in self._all[name].axes:
            raise self._broken(f"{name} must have real and imaginary parts along '{PAIR}'")
        pairs = self._in_order(name, (*wanted, PAIR), self._numbers(name))
        names = self._names(PAIR) if PAIR in self._all else ["re", "im"]
        if sorted(names) != ["im", "re"] or pairs.shape[-1] != 2:
            raise self._broken(f"{PAIR} = {names}: must be re and im")
        both = pairs[..., names.index("re")] + 1j * pairs[..., names.index("im")]
        return np.asarray(both[:, :, self._dofs("influenced_dof")], np.complex128)

    def _names(self, axis: str) -> list[str]:
        values = self._all[axis].values
        if values.dtype.kind == "S" and values.ndim == 2:  # characters
            values = np.array([b"".join(row) for row in values])
        return [each.decode() if isinstance(each, bytes) else str(each) for each in values.ravel()]

    def _dofs(self, axis: str) -> list[int]:
        if axis not in self._all:
            raise self._broken(f"{axis} missing")
        names = [name.strip().strip("\0") for name in self._names(axis)]
        if sorted(names) != sorted(DOFS):
            raise self._broken(f"{axis} = {', '.join(names)}: must be {', '.join(DOFS)}, those of one rigid body")
        return [names.index(each) for each in DOFS]
