"""Reads NetCDF: classic files with SciPy, those in HDF5 with h5py."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.extras import need_extra

CLASSIC, HDF5 = b"CDF", b"\x89HDF"
MAX_VALUES = 50_000_000
ATTRIBUTES = ("units", "standard_name", "positive", "_FillValue", "missing_value", "scale_factor", "add_offset")


class NotNetcdfError(ValueError):
    """The file is no NetCDF."""


@dataclass(frozen=True, eq=False)
class NetcdfVariable:
    """An array, the names of its axes, and its attributes of ATTRIBUTES: texts or numbers."""

    axes: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any] = field(default_factory=dict)


def read_netcdf(path: Path, what: str) -> dict[str, NetcdfVariable]:
    """Return the variables of at most MAX_VALUES values by name.

    what: the file's role, for messages. Raises NotNetcdfError, MissingExtraError, or whatever the readers raise for a
    damaged file.
    """
    with path.open("rb") as file:
        magic = file.read(4)
    if _is_classic(magic):
        from scipy.io import netcdf_file

        with netcdf_file(path, mmap=False) as data:
            return {
                name: NetcdfVariable(tuple(each.dimensions), np.array(each.data), _attributes(each._attributes))
                for name, each in data.variables.items()
                if np.prod(each.shape) <= MAX_VALUES
            }
    if magic == HDF5:
        return _of_hdf5(path, what)
    raise NotNetcdfError("must be a NetCDF file: neither classic nor HDF5")


def require_whole_netcdf(path: Path) -> None:
    """Raise ValueError if a classic file lacks values, which GDAL reads as zeros. HDF5 checks its own files.

    Raises OSError if it cannot be read.
    """
    with path.open("rb") as file:
        if not _is_classic(file.read(4)):
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


def _of_hdf5(path: Path, what: str) -> dict[str, NetcdfVariable]:
    need_extra("h5py", "seakeeping", f"{what}, NetCDF in HDF5,")
    import h5py

    found = {}
    with h5py.File(path, "r") as data:
        for name, each in data.items():
            if not isinstance(each, h5py.Dataset) or each.size is None or each.size > MAX_VALUES:
                continue
            axes = [axis[0].name.strip("/") if len(axis) else "" for axis in each.dims]
            if each.is_scale and each.ndim == 1 and axes == [""]:
                axes = [name]
            values = each[()] if each.ndim else np.asarray(each[()])
            found[name] = NetcdfVariable(tuple(axes), values, _attributes(each.attrs))
    return found


def _attributes(given: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in ATTRIBUTES:
        if (value := given.get(name)) is None:
            continue
        value = value.item() if isinstance(value, np.generic | np.ndarray) and np.size(value) == 1 else value
        found[name] = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return found
