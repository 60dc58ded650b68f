"""Reads fields of an ocean model: currents, temperature and salinity in space and time, from NetCDF or CSV.

Quantities have the names of the Climate and Forecast conventions (cfconventions.org): in NetCDF the attribute
`standard_name`, or else the variable's name; in CSV a column NAME_UNIT, such as depth_meter. Cells without a value lie
below the bed or on land.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.extras import MissingExtraError
from uwsim.base.texts.csv_table import read_csv
from uwsim.base.texts.text_file import first_bytes
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.netcdf_file import NetcdfVariable, NotNetcdfError, read_netcdf

MAX_CELLS = 20_000_000
LENGTH = dict.fromkeys(("m", "meter", "meters", "metre", "metres"), (1.0, 0.0))
SPEED = {
    **dict.fromkeys(("m s-1", "m/s", "m s**-1", "meter_per_sec", "m_s", "meter second-1"), (1.0, 0.0)),
    **dict.fromkeys(("cm s-1", "cm/s", "cm_s"), (0.01, 0.0)),
}
CELSIUS = {
    **dict.fromkeys(("degC", "degree_C", "degrees_C", "deg_C", "celsius", "Celsius", "degree_Celsius"), (1.0, 0.0)),
    "K": (1.0, -273.15), "kelvin": (1.0, -273.15),
}  # fmt: skip
SALT = dict.fromkeys(("psu", "PSU", "1", "1e-3", "0.001", "PSS-78", ""), (1.0, 0.0))
ANGLE = dict.fromkeys(
    ("degree", "degrees", "deg", "degrees_north", "degree_north", "degrees_east", "degree_east"), (1.0, 0.0)
)
TIME = {
    **dict.fromkeys(("s", "sec", "second", "seconds"), (1.0, 0.0)), "minutes": (60.0, 0.0),
    **dict.fromkeys(("h", "hour", "hours"), (3600.0, 0.0)), **dict.fromkeys(("d", "day", "days"), (86400.0, 0.0)),
}  # fmt: skip
AXES = {
    "elapsed_time": ("t", TIME), "time": ("t", TIME), "latitude": ("y", ANGLE), "longitude": ("x", ANGLE),
    "depth": ("depth", LENGTH),
}  # fmt: skip
QUANTITIES = {
    "eastward_sea_water_velocity": ("u", SPEED), "northward_sea_water_velocity": ("v", SPEED),
    "upward_sea_water_velocity": ("w", SPEED), "sea_water_temperature": ("temperature", CELSIUS),
    "sea_water_potential_temperature": ("temperature", CELSIUS), "sea_water_salinity": ("salinity", SALT),
    "sea_water_practical_salinity": ("salinity", SALT),
}  # fmt: skip
KNOWN = {**AXES, **QUANTITIES}


@dataclass(frozen=True, eq=False)
class OceanField:
    """Values by quantity: u, v, w [m/s, east, north, up], temperature [deg C] and salinity [psu], (nt, nz, ny, nx).

    t_s: from the file's first time. z_m: rising, 0 at the surface. latitude_deg, longitude_deg: rising. No NaN.
    """

    t_s: Floats
    z_m: Floats
    latitude_deg: Floats
    longitude_deg: Floats
    values: Mapping[str, Floats]

    def need(self, path: Path, *names: str) -> list[Floats]:
        """Return the values of quantities. Raises ScenarioError for a missing one."""
        for name in names:
            if name not in self.values:
                known = " or ".join(each for each, (short, _) in QUANTITIES.items() if short == name)
                raise ScenarioError(f"ocean '{path}': has no {known}")
        return [self.values[name] for name in names]


def read_ocean(path: Path) -> OceanField:
    """Read a field: NetCDF by its first bytes, anything else as CSV. Raises ScenarioError."""
    try:
        magic = first_bytes(path, 4)
        axes, values = _of_netcdf(path) if magic[:3] in (b"CDF", b"\x89HD") else _of_csv(path)
    except (ScenarioError, MissingExtraError):
        raise
    except NotNetcdfError as error:
        raise _broken(path, str(error)) from None
    except Exception as error:  # damaged files raise anything in both readers
        raise _broken(path, f"is not readable: {type(error).__name__}: {error}") from error
    for axis, name in ((1, "depth"), (2, "latitude"), (3, "longitude"), (0, "time")):
        values, axes[axis] = _rising(path, name, axis, axes[axis], values)
    t_s, depth_m, latitude_deg, longitude_deg = axes
    down = {name: np.flip(array, 1) for name, array in values.items()}
    return OceanField(
        t_s - t_s[0], -depth_m[::-1], latitude_deg, longitude_deg,
        {name: _filled(path, name, array) for name, array in down.items()},
    )  # fmt: skip


def _broken(path: Path, text: str) -> ScenarioError:
    return ScenarioError(f"ocean '{path}': {text}")


def _rising(path: Path, name: str, axis: int, values: Floats, fields: Any) -> tuple[dict[str, Floats], Floats]:
    """Return the fields and an axis in rising order."""
    if not np.all(np.isfinite(values)):
        raise _broken(path, f"{name} must be finite")
    order = np.argsort(values)
    if np.any(np.diff(values[order]) <= 0):
        raise _broken(path, f"{name} must not repeat values")
    if np.array_equal(order, np.arange(len(order))):
        return fields, values
    return {key: np.take(array, order, axis) for key, array in fields.items()}, values[order]


def _filled(path: Path, name: str, values: Floats) -> Floats:
    """Return values without gaps: the bed's from above, land's from the nearest water of the same height."""
    gaps = ~np.isfinite(values)
    if not gaps.any():
        return values
    if gaps.all(axis=(1, 2, 3)).any():
        raise _broken(path, f"{name} has a time without any value")
    from scipy.ndimage import distance_transform_edt  # SciPy takes a while to import

    values = np.where(gaps, np.nan, values)
    for k in range(values.shape[1] - 2, -1, -1):  # from the surface down
        values[:, k] = np.where(np.isnan(values[:, k]), values[:, k + 1], values[:, k])
    for k in range(values.shape[1] - 1, -1, -1):
        for layer in values[:, k]:
            dry = np.isnan(layer)
            if dry.any() and not dry.all():
                layer[...] = layer[tuple(distance_transform_edt(dry, return_distances=False, return_indices=True))]
    for k in range(1, values.shape[1]):  # a layer without any water: from below
        values[:, k] = np.where(np.isnan(values[:, k]), values[:, k - 1], values[:, k])
    return values


def _scaled(path: Path, name: str, unit: str, values: Floats) -> Floats:
    units = KNOWN[name][1]
    if units is TIME:
        unit = unit.split(" since ")[0]
    if unit not in units:
        raise _broken(path, f"{name}: unit '{unit[:40]}': must be one of {', '.join(filter(None, units))}")
    factor, offset = units[unit]
    return factor * values + offset


def _of_csv(path: Path) -> tuple[list[Floats], dict[str, Floats]]:
    try:
        table = read_csv(path)
        columns: dict[str, Floats] = {}
        for column in table.columns:
            name = max((each for each in KNOWN if column == each or column.startswith(f"{each}_")), key=len, default="")
            if name:
                numbers = table.numbers(column, may_lack=name in QUANTITIES)
                columns[KNOWN[name][0]] = _scaled(path, name, column[len(name) + 1 :], numbers)
    except ValueError as error:
        raise error if isinstance(error, ScenarioError) else ScenarioError(f"ocean {error}") from None
    columns.setdefault("t", np.zeros(len(table)))
    missing = [name for name, (short, _) in AXES.items() if short not in columns and name != "elapsed_time"]
    if missing:
        raise _broken(path, f"has no column {missing[0]}_UNIT: axes are time, depth, latitude and longitude")
    found = [np.unique(columns.pop(key), return_inverse=True) for key in ("t", "depth", "y", "x")]
    axes, places = [each[0] for each in found], tuple(each[1] for each in found)
    shape = tuple(len(axis) for axis in axes)
    cells = int(np.prod([float(n) for n in shape]))
    if cells != len(table) or len(np.unique(np.ravel_multi_index(places, shape))) != cells:
        text = " x ".join(map(str, shape))
        raise _broken(path, f"{len(table)} rows for {text} times, depths, latitudes, longitudes: must be one for each")
    values = {}
    for quantity, numbers in columns.items():
        values[quantity] = np.full(shape, np.nan)
        values[quantity][places] = numbers
    return axes, values


def _of_netcdf(path: Path) -> tuple[list[Floats], dict[str, Floats]]:
    variables = read_netcdf(path, f"ocean '{path}'", KNOWN)
    known = {}
    for key, each in variables.items():
        name = _quantity(key, each.attributes)
        if name in KNOWN and KNOWN[name][0] not in known:
            known[KNOWN[name][0]] = (key, name, each)
    lacking = [name for name, (short, _) in AXES.items() if short not in known and short != "t"]
    if lacking:
        raise _broken(path, f"has no variable of the standard name {lacking[0]}")
    axes, dims = [], []
    for short in ("t", "depth", "y", "x"):
        if short not in known:
            axes.append(np.zeros(1))
            dims.append("")
            continue
        key, name, each = known[short]
        if each.values.ndim > 1 or (each.values.ndim == 1 and each.axes != (key,)):
            raise _broken(path, f"{key}: axes must be one-dimensional: curvilinear grids are not read")
        axes.append(
            _scaled(path, name, str(each.attributes.get("units", "")), np.atleast_1d(_numbers(path, key, each)))
        )
        dims.append(key if each.values.ndim else "")
    shape = tuple(len(axis) for axis in axes)
    values = {}
    for short, (key, name, each) in known.items():
        if name not in QUANTITIES:
            continue
        if not set(each.axes) <= set(dims) or np.size(each.values) != np.prod([float(n) for n in shape]):
            raise _broken(path, f"{key} has the axes {', '.join(each.axes)}: must be {', '.join(filter(None, dims))}")
        if np.size(each.values) > MAX_CELLS:
            raise _broken(path, f"{key} has {np.size(each.values)} values: must be at most {MAX_CELLS}")
        order = [each.axes.index(dim) for dim in dims if dim in each.axes]
        numbers = np.transpose(_numbers(path, key, each), order).reshape(shape)
        values[short] = _scaled(path, name, str(each.attributes.get("units", "")), numbers)
    return axes, values


def _quantity(key: str, attributes: Mapping[str, Any]) -> str:
    return str(attributes.get("standard_name", key))


def _numbers(path: Path, key: str, variable: NetcdfVariable) -> Floats:
    """Return a variable's values, unpacked, with NaN for missing ones."""
    values = np.asarray(variable.values)
    if values.dtype.kind not in "iuf":
        raise _broken(path, f"{key} must hold real numbers")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        found = np.array(values, np.float64)
    given = variable.attributes
    for name in ("_FillValue", "missing_value"):
        if isinstance(fill := given.get(name), int | float):
            found[values == fill] = np.nan
    scale, offset = given.get("scale_factor", 1.0), given.get("add_offset", 0.0)
    if not (isinstance(scale, int | float) and isinstance(offset, int | float)):
        raise _broken(path, f"{key}: scale_factor and add_offset must be numbers")
    return scale * found + offset
