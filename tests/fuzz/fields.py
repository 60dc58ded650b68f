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


def cast(data: bytes, folder: Path) -> list[bytes]:
    """Read a measured column of water, and make a scenario's water of it."""
    from uwsim.scenario.build.water import build_water
    from uwsim.scenario.read.validated import validated
    from uwsim.scenario.spec.water import Water

    path = folder / "cast"
    path.write_bytes(data)
    water = build_water(validated(Water, {"profile": {"kind": "table", "file": path}}), bottom_depth_m=20.0, seed=0)
    return [np.array([water.sound_speed_m_s(z), water.density_at_kg_m3(z)]).tobytes() for z in (0.0, -5.0, -20.0)]


def casts() -> list[bytes]:
    """Return small casts: CARIS, Kongsberg, Sea-Bird, Valeport with and without names, decimal commas, and pairs."""
    bird = (
        "* Sea-Bird\n# name 0 = depSM: Depth [salt water, m]\n# name 1 = t090C: Temperature [ITS-90, deg C]\n"
        "# name 2 = flag: flag\n# bad_flag = -9.990e-29\n*END*\n      1.000    15.0000 0.0000e+00\n"
        "      2.000    14.0000-9.990e-29\n      3.000    13.0000 0.0000e+00\n"
    )
    texts = (
        "[SVP_VERSION_2]\nx.svp\nSection 2024-126 14:33:12 43:51:34 -70:45:16\n0.5 1500.1\n9.5 1490.2\n",
        "( SoundVelocity 1.0 0 201203212242 22.5 -156.5 -1 0 0 OMS01 P 0002 )\n0.00 1531.40\n12000.00 1675.82\n",
        bird,
        "MiniSVP: S/N 1\nPressure units: dBar\n00.111\t20.941\t1522.0\n03.122\t19.7\t1520.5\n",
        "[Data]\nDate\tDepth\tSound Velocity\n\tm\tm/s\n07/27/2024\t2.0\t1537.4\n07/27/2024\t2.1\t1537.5\n",
        "Depth [ft];Temp [F];Salinity\n0,5;52,25;30,1\n1,5;52,00;30,2\n",
        "header\n3, 1504.92\n1.2, 1504.80\n",
    )
    return [text.encode() for text in texts]


def argo() -> list[bytes]:
    """Return a profile of an Argo float in classic NetCDF."""
    from scipy.io import netcdf_file

    file = io.BytesIO()
    with netcdf_file(file, "w") as data:
        data.createDimension("N_PROF", 1)
        data.createDimension("N_LEVELS", 2)
        data.createVariable("DATA_MODE", "c", ("N_PROF",))[:] = b"D"
        for name, values in (("PRES", [5, 10]), ("TEMP", [9, 8]), ("PSAL", [34, 35])):
            data.createVariable(name, "f", ("N_PROF", "N_LEVELS"))[:] = [values]
            data.createVariable(f"{name}_QC", "c", ("N_PROF", "N_LEVELS"))[:] = b"1"
        data.flush()
        return [file.getvalue()]
