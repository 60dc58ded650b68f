"""Reads NetCDF: classic files with SciPy, those in HDF5 with h5py."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.texts.text_file import first_bytes
from uwsim.scenario.read.hdf5_file import SIGNATURE, inside_hdf5

CLASSIC = b"CDF"
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


Needed = Callable[[str, Mapping[str, Any]], bool]
"""A variable is needed or not, by its name and attributes: others, of any number and size, are not read."""


def read_netcdf(path: Path, what: str, needed: Needed) -> dict[str, NetcdfVariable]:
    """Return the needed variables of at most MAX_VALUES values by name.

    what: the file's role, for messages. Raises NotNetcdfError, Hdf5Error, MissingExtraError, or whatever the readers
    raise for a damaged file.
    """
    magic = first_bytes(path, 4)
    if _is_classic(magic):
        from scipy.io import netcdf_file

        with netcdf_file(path, mmap=True) as data:  # maps the values, so that those not needed are not read
            return {
                name: NetcdfVariable(tuple(each.dimensions), np.array(each.data), _attributes(each._attributes))
                for name, each in data.variables.items()
                if np.prod([float(n) for n in each.shape]) <= MAX_VALUES and needed(name, _attributes(each._attributes))
            }
    if magic == SIGNATURE[:4]:
        return _of_hdf5(path, what, needed)
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


def _of_hdf5(path: Path, what: str, needed: Needed) -> dict[str, NetcdfVariable]:
    found = {}
    with inside_hdf5(path, f"{what}, NetCDF in HDF5") as data:
        for name in data.names():
            if (each := data.dataset(name)) is None or each.size is None or each.size > MAX_VALUES:
                continue
            attributes = _attributes(data.attributes(each, ATTRIBUTES))
            if not needed(name, attributes):
                continue
            axes = [axis[0].name.strip("/") if len(axis) else "" for axis in each.dims]
            if each.is_scale and each.ndim == 1 and axes == [""]:
                axes = [name]
            found[name] = NetcdfVariable(tuple(axes), data.values(name, each), attributes)
    return found


def _attributes(given: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in ATTRIBUTES:
        if (value := given.get(name)) is None:
            continue
        value = value.item() if isinstance(value, np.generic | np.ndarray) and np.size(value) == 1 else value
        found[name] = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
    return found
