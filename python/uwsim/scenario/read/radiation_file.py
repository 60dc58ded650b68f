"""Reads the table of a floating hull's hydrodynamics: Capytaine's dataset as NetCDF, or a file of radiation_bem."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import MissingExtraError
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.hdf5_file import Hdf5Error
from uwsim.scenario.read.netcdf_file import NetcdfVariable, NotNetcdfError, read_netcdf
from uwsim.scenario.read.radiation_bem import read_wamit, read_wec_sim
from uwsim.scenario.read.radiation_table import Array, Complex, RadiationTable, broken_file, table_of

DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
WAMIT, WEC_SIM = ".1", ".h5"
MATRICES, FORCES = ("added_mass", "radiation_damping"), ("diffraction_force", "Froude_Krylov_force")
DRIFTS = ("drift_force_surge", "drift_force_sway", "drift_force_yaw")
"""The mean drift, as Capytaine's far_field_mean_drift_force returns it: for pairs of headings, complex."""
HEADING_PAIR = ("wave_direction_k", "wave_direction_l")
PAIR = "complex"
"""The axis of real and imaginary parts."""
AXES = ("omega", "wave_direction", "influenced_dof", "radiating_dof", *HEADING_PAIR, PAIR)
SCALARS = ("rotation_center", "rho", "g", "disp_mass", "water_depth", "forward_speed")
NEEDED = frozenset((*MATRICES, *FORCES, *DRIFTS, *AXES, *SCALARS))


def read_radiation(path: Path) -> RadiationTable:
    """Read a table. Raises ScenarioError."""
    try:
        if path.suffix == WAMIT:
            return read_wamit(path)
        if path.suffix == WEC_SIM:
            return read_wec_sim(path)
        variables = read_netcdf(path, f"radiation '{path}'", lambda name, _: name in NEEDED)
    except (ScenarioError, MissingExtraError):
        raise
    except Hdf5Error as error:
        raise broken_file(path, str(error)) from None
    except NotNetcdfError:
        raise broken_file(
            path, "must be a NetCDF file of Capytaine, WAMIT's .1 or WEC-Sim's .h5: neither classic NetCDF nor HDF5"
        ) from None
    except Exception as error:  # damaged files raise anything in both readers
        raise broken_file(path, f"is not readable: {type(error).__name__}: {error}") from error
    return _Reader(path, variables).table()


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
        matrices, centre_m = [self._matrices(name) for name in MATRICES], self._vector("rotation_center")
        forces = [self._forces(name) for name in FORCES]
        if self._is_moving():
            raise self._broken("forward_speed must be 0 m/s: tables of a moving hull are not read")
        return table_of(
            self._path,
            omega,
            (matrices[0], matrices[1]),
            heading,
            (forces[0] + forces[1], forces[1]),
            self._drift(centre_m),
            centre_m=centre_m,
            density_kg_m3=self._scalar("rho", 0.0),
            gravity_m_s2=self._scalar("g", 0.0),
            displaced_kg=self._scalar("disp_mass", 0.0) if "disp_mass" in self._all else None,
            water_depth_m=self._scalar("water_depth", 0.0) if "water_depth" in self._all else np.inf,
        )

    def _broken(self, text: str) -> ScenarioError:
        return broken_file(self._path, text)

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
        both = self._complex(name, ("omega", "wave_direction", "influenced_dof"))
        return both[:, :, self._dofs("influenced_dof")]

    def _complex(self, name: str, wanted: tuple[str, ...]) -> Complex:
        values = self._all[name].values
        if values.dtype.names is not None and len(values.dtype.names) == 2:  # HDF5's complex numbers
            real, imaginary = (np.asarray(values[part], np.float64) for part in values.dtype.names)
            return np.asarray(self._in_order(name, wanted, real + 1j * imaginary), np.complex128)
        if PAIR not in self._all[name].axes:
            raise self._broken(f"{name} must have real and imaginary parts along '{PAIR}'")
        pairs = self._in_order(name, (*wanted, PAIR), self._numbers(name))
        names = self._names(PAIR) if PAIR in self._all else ["re", "im"]
        if sorted(names) != ["im", "re"] or pairs.shape[-1] != 2:
            raise self._broken(f"{PAIR} = {names}: must be re and im")
        return np.asarray(pairs[..., names.index("re")] + 1j * pairs[..., names.index("im")], np.complex128)

    def _drift(self, centre_m: Array) -> Array | None:
        """Return the mean drift about the centre, None if the file has none. Capytaine's moment is about its origin."""
        given = [name for name in DRIFTS if name in self._all]
        if not given:
            return None
        if len(given) < len(DRIFTS):
            raise self._broken(f"has {', '.join(given)} alone: must have {', '.join(DRIFTS)}, or none of them")
        surge, sway, yaw = (self._drift_along(name) for name in DRIFTS)
        return np.stack([surge, sway, yaw - centre_m[0] * sway + centre_m[1] * surge], axis=-1)

    def _drift_along(self, name: str) -> Array:
        if HEADING_PAIR[0] not in self._all[name].axes:
            return np.asarray(self._in_order(name, ("omega", "wave_direction"), self._numbers(name)), np.float64)
        pairs = self._complex(name, ("omega", *HEADING_PAIR))
        heading = self._numbers("wave_direction").ravel()
        if any(not np.array_equal(self._numbers(axis).ravel(), heading) for axis in HEADING_PAIR if axis in self._all):
            raise self._broken(f"{' and '.join(HEADING_PAIR)} must have the values of wave_direction")
        if pairs.shape[1:] != (heading.size, heading.size):
            raise self._broken(f"{name} must have a value for each pair of the {heading.size} headings")
        return np.asarray(np.diagonal(pairs.real, axis1=1, axis2=2), np.float64)

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
