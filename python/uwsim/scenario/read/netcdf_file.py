"""Reads NetCDF: classic files with SciPy, those in HDF5 with h5py."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import first_bytes
from uwsim.scenario.read.contained import run_contained

CLASSIC, SIGNATURE = b"CDF", b"\x89HDF\r\n\x1a\n"
PROCESS, PROCESS_CPU_S = Path(__file__).with_name("hdf5_process.py"), 5
MAX_VALUES = 50_000_000
ATTRIBUTES = ("units", "standard_name", "positive", "_FillValue", "missing_value", "scale_factor", "add_offset")


class NotNetcdfError(ValueError):
    """The file is no NetCDF, or a damaged one."""


@dataclass(frozen=True, eq=False)
class NetcdfVariable:
    """An array, the names of its axes, and its attributes of ATTRIBUTES: texts or numbers."""

    axes: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any] = field(default_factory=dict)


def read_netcdf(path: Path, what: str, names: Collection[str]) -> dict[str, NetcdfVariable]:
    """Return the variables with one of these names, or standard names, by name: at most MAX_VALUES values each.

    what: the file's role, for messages. Raises NotNetcdfError, MissingExtraError, or whatever SciPy raises for a
    damaged file.
    """
    magic = first_bytes(path, 4)
    if _is_classic(magic):
        from scipy.io import netcdf_file

        with netcdf_file(path, mmap=True) as data:  # maps the values, so that those not needed are not read
            return {
                name: NetcdfVariable(tuple(each.dimensions), np.array(each.data), _attributes(each._attributes))
                for name, each in data.variables.items()
                if np.prod([float(n) for n in each.shape]) <= MAX_VALUES
                and not {name, _attributes(each._attributes).get("standard_name")}.isdisjoint(names)
            }
    if magic == SIGNATURE[:4]:
        return _of_hdf5(path, what, names)
    raise NotNetcdfError("must be a NetCDF file: neither classic nor HDF5")


def require_whole_netcdf(path: Path) -> None:
    """Raise ValueError if a classic file lacks values, which GDAL reads as zeros. HDF5 checks its own files.

    Raises OSError if it cannot be read.
    """
    if not _is_classic(first_bytes(path, 4)):
        return
    from scipy.io import netcdf_file

    try:
        with netcdf_file(path, mmap=True):  # maps the values without reading them
            pass
    except OSError:
        raise
    except Exception as error:  # the reader raises anything for a damaged file
        raise ValueError(f"is cut short or damaged: {' '.join(str(error).split())}") from None


def _is_classic(magic: bytes) -> bool:
    return magic.startswith(CLASSIC) and len(magic) == 4 and magic[3] in (1, 2)


def _of_hdf5(path: Path, what: str, names: Collection[str]) -> dict[str, NetcdfVariable]:
    need_extra("h5py", f"{what}, NetCDF in HDF5, HDF5,")
    asked = str(path), [*names], ATTRIBUTES
    try:
        made = run_contained(PROCESS, "HDF5", *asked, reads=[path], cpu_s=PROCESS_CPU_S)
    except ValueError as error:
        raise NotNetcdfError(str(error)) from None
    found = {}
    for k, name in enumerate(made["names"].tolist()):
        given = {key: made[f"{k} {key}"] for key in ATTRIBUTES if f"{k} {key}" in made}
        found[name] = NetcdfVariable(tuple(made[f"{k} axes"].tolist()), made[f"{k} values"], _attributes(given))
    return found


def _attributes(given: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in ATTRIBUTES:
        if (value := given.get(name)) is None:
            continue
        value = value.item() if isinstance(value, np.generic | np.ndarray) and np.size(value) == 1 else value
        found[name] = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return found
