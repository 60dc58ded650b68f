"""Profiles of Argo floats (NetCDF) as casts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.read.cast_quantity import LATITUDE_DEG, PRESSURE, depth_at_m
from uwsim.scenario.read.netcdf_file import read_netcdf

Floats = NDArray[np.float64]
BAD_QC = (b"3", b"4", b"9")
"""Argo's flags (Argo user's manual, table 2): probably bad, bad, missing."""


def read_argo(path: Path, name: str) -> tuple[dict[str, Floats], list[str]]:
    """Read the first profile of an Argo float: adjusted values where it has them, without those flagged as bad."""
    names = {"PRES": PRESSURE, "TEMP": "temperature_deg_c", "PSAL": "salinity_psu"}
    wanted = {f"{key}{end}" for key in names for end in ("", "_QC", "_ADJUSTED", "_ADJUSTED_QC")}
    try:
        held = read_netcdf(path, f"cast '{name}'", wanted | {"DATA_MODE", "LATITUDE"})
    except ImportError:
        raise
    except Exception as error:  # damaged files raise anything in both readers
        raise ValueError(f"{name}: not a readable NetCDF: {' '.join(str(error).split())}") from None
    if not {"PRES", "TEMP"} <= held.keys():
        raise ValueError(f"{name}: not an Argo profile: must have the variables PRES and TEMP")
    mode = bytes(np.ravel(held["DATA_MODE"].values)[:1].tobytes()) if "DATA_MODE" in held else b"R"
    columns, notes = {}, []
    for short, key in names.items():
        used = f"{short}_ADJUSTED" if mode in (b"A", b"D") and f"{short}_ADJUSTED" in held else short
        if used not in held:
            continue
        values = np.atleast_2d(np.array(held[used].values))
        if values.ndim != 2 or values.dtype.kind not in "iuf" or not values.size:
            raise ValueError(f"{name}: {used} has the shape {held[used].values.shape}: must be profiles by levels")
        found = values[0].astype(np.float64)
        found[found == held[used].attributes.get("_FillValue", 99999.0)] = math.nan
        if (flags := held.get(f"{used}_QC")) is not None and np.size(flags.values) == values.size:
            flag = np.reshape(np.array(flags.values, "S1"), values.shape)[0]
            found[np.isin(flag, BAD_QC)] = math.nan
        columns[key] = found
        if short == "PRES" and len(values) > 1:
            notes.append(f"the first of its {len(values)} profiles is used")
    if len({len(each) for each in columns.values()}) > 1:
        raise ValueError(f"{name}: PRES, TEMP and PSAL must have the same number of levels")
    latitude = held["LATITUDE"].values if "LATITUDE" in held else np.array([LATITUDE_DEG])
    columns["depth_m"] = depth_at_m(columns.pop(PRESSURE), _latitude(latitude))
    if mode not in (b"A", b"D"):
        notes.append("values are those in real time, not adjusted")
    return columns, notes


def _latitude(values: Any) -> float:
    first = float(np.ravel(values)[0]) if np.size(values) and np.asarray(values).dtype.kind in "iuf" else math.nan
    return first if abs(first) <= 90.0 else LATITUDE_DEG
