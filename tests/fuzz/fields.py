"""Fields in the water: readers of their formats for the fuzzers, and the small files with which these start."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np


def current(suffix: str) -> Callable[[bytes, Path], Any]:
    """Return a reader of a current's grid in metres."""

    def read(data: bytes, folder: Path) -> list[bytes]:
        from uwsim.scenario.read.current_grid import read_current_grid

        path = folder / f"current{suffix}"
        path.write_bytes(data)
        return [array.tobytes() for array in read_current_grid(path)]

    return read


def ocean(data: bytes, folder: Path) -> list[bytes]:
    """Read an ocean model's field: NetCDF or CSV."""
    from uwsim.scenario.read.ocean_file import read_ocean

    path = folder / "ocean"
    path.write_bytes(data)
    field = read_ocean(path)
    return [axis.tobytes() for axis in (field.t_s, field.z_m, field.latitude_deg, *field.values.values())]


def ocean_csv() -> list[bytes]:
    """Return a field of 2 x 2 x 2 x 2 cells, one of them below the bed."""
    head = "elapsed_time_hours,depth_meter,latitude_degree,longitude_degree,sea_water_temperature_degC"
    rows = [
        f"{t},{10 * z},{43 + y},{5 + x},{15 - z if t + z + y + x < 4 else ''}" for t, z, y, x in np.ndindex(2, 2, 2, 2)
    ]
    return ["\n".join([head, *rows, ""]).encode()]


def ocean_netcdf() -> list[bytes]:
    """Return a field in classic NetCDF."""
    from scipy.io import netcdf_file

    file = io.BytesIO()
    with netcdf_file(file, "w") as data:
        for name, unit in (("time", "hours"), ("depth", "m"), ("latitude", "degree"), ("longitude", "degree")):
            data.createDimension(name, 2)
            axis = data.createVariable(name, "d", (name,))
            axis[:], axis.units = [0.0, 1.0], unit
        warm = data.createVariable("sea_water_temperature", "h", ("time", "depth", "latitude", "longitude"))
        warm[:], warm.units, warm.scale_factor, warm._FillValue = 15, "degC", 0.5, np.int16(-1)
        data.flush()
        return [file.getvalue()]
