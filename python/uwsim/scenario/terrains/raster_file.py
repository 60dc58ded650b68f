"""Opens an elevation raster; one of a rich format is imported by a process of its own, since GDAL may crash on it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from affine import Affine
from rasterio.crs import CRS
from rasterio.env import Env
from rasterio.errors import NotGeoreferencedWarning
from rasterio.io import DatasetReader

from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import first_bytes, require_regular
from uwsim.scenario.read import raster_process
from uwsim.scenario.read.contained import run_contained
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.netcdf_file import CLASSIC, SIGNATURE
from uwsim.scenario.spec.terrain import MAX_NODES

FORMATS = (
    *("GTiff", "AAIGrid", "HFA", "EHdr", "SRTMHGT", "USGSDEM", "DTED", "BAG", "netCDF", "GSAG", "GSBG", "GS7BG"),
    *("ENVI", "SAGA", "XYZ", "BT", "PCRaster", "GRIB"),
)
"""GDAL's names of formats that contain the elevations themselves. Others, such as VRT, refer to further files and
servers, which would let an untrusted file read anything that this machine can access."""

RICH = (CLASSIC, b"GRIB")
"""The first bytes of formats with which GDAL's libraries may crash, or fill the memory, as HDF5's: netCDF, GRIB."""


@contextmanager
def opened(path: Path, band: int) -> Iterator[DatasetReader]:
    """Open a raster; one of a rich format is read in a process of its own. Raises RasterioError, ScenarioError."""
    is_hdf5 = _is_hdf5(path)
    if is_hdf5:
        need_extra("h5py", f"terrain '{path.name}', HDF5,")
    if is_hdf5 or first_bytes(path, 4).startswith(RICH):
        yield _read_apart(path, band, is_hdf5)
        return
    with Env(), warnings.catch_warnings():
        warnings.simplefilter("ignore", NotGeoreferencedWarning)  # `_read` raises an error instead
        with raster_process.opened(str(path), list(FORMATS)) as file:
            yield file


def _read_apart(path: Path, band: int, is_hdf5: bool) -> DatasetReader:
    """Return what has the attributes of an open raster, and of one band the values."""
    asked = str(path), band, FORMATS, 4 * MAX_NODES, is_hdf5
    try:
        arrays = run_contained(Path(raster_process.__file__), "GDAL", *asked, reads=[path])
    except ValueError as error:
        raise ScenarioError(f"terrain '{path.name}': not a readable elevation raster: {error}", at=("file",)) from None
    found: dict[str, Any] = {name: each.tolist() if each.ndim < 2 else each for name, each in arrays.items()}
    found["transform"] = Affine(*found["transform"])
    found["crs"] = CRS.from_wkt(found["crs"]) if found["crs"] else None
    found["read_masks"], found["read"] = (lambda band: found["masks"]), (lambda band, out_dtype: found["values"])
    return cast(DatasetReader, SimpleNamespace(**found))


def _is_hdf5(path: Path) -> bool:
    """Return whether there is a signature where readers look for it: behind a user's block of 512 bytes, 1024, ..."""
    at, size = 0, path.stat().st_size
    with require_regular(path).open("rb") as file:
        while at < size:
            file.seek(at)
            if file.read(len(SIGNATURE)) == SIGNATURE:
                return True
            at = max(512, 2 * at)
    return False
