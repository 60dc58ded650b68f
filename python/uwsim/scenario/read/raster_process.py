"""Import of a raster by GDAL: the script of a contained process; to start quickly, it imports no uwsim."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from affine import Affine
from rasterio.crs import CRS
from rasterio.env import Env
from rasterio.io import DatasetReader

COVERAGE, VALUES, FILL = "BathymetryCoverage", "Group_001/values", 1e6
PLACE = ("gridOriginLongitude", "gridOriginLatitude", "gridSpacingLongitudinal", "gridSpacingLatitudinal")


def opened(path: str, formats: list[str]) -> DatasetReader:
    """Open a raster for reading, in one of GDAL's formats by name. Raises RasterioError."""
    return DatasetReader(path, driver=formats)


@contextmanager
def _opened_apart(path: str, formats: list[str], is_hdf5: bool) -> Iterator[Any]:
    """Open an S-102, or a raster as `opened` does. Raises RasterioError, ValueError, OSError."""
    if is_hdf5:
        import h5py

        from uwsim.scenario.read.hdf5_process import require_inside

        with h5py.File(path, "r") as file:
            require_inside(file)  # GDAL follows links out of it, into pipes as well
            if COVERAGE in file:
                yield _S102(file)
                return
    with opened(path, formats) as raster:
        yield raster


class _S102:
    """The elevations of an S-102, one band for each coverage, by the names of rasterio. Raises ValueError.

    IHO S-102, editions 2.1 to 3.0.0, ch. 10: depths, positive down, at the centres of cells, in rows from the south;
    uncertainties are optional. GDAL up to 3.10 reads only files that have them.
    """

    driver = "S102"

    def __init__(self, file: Any) -> None:
        names = [name for name in sorted(file[COVERAGE]) if VALUES in file[COVERAGE][name]]
        self._grids = [file[COVERAGE][name][VALUES] for name in names]
        places = [[float(file[COVERAGE][name].attrs[each]) for each in PLACE] for name in names]
        if not names or any(grid.ndim != 2 or "depth" not in (grid.dtype.names or ()) for grid in self._grids):
            raise ValueError(f"an S-102 without depths in {COVERAGE}/{COVERAGE}.01/{VALUES}")
        if places != places[:1] * len(places) or len({grid.shape for grid in self._grids}) > 1:
            raise ValueError(f"an S-102 whose {len(places)} coverages have grids of their own: must be one grid")
        self._fill = FILL
        if (table := file.get(f"Group_F/{COVERAGE}")) is not None and "fillValue" in (table.dtype.names or ()):
            self._fill = float(table[0]["fillValue"])
        west, south, width, height = places[0]
        self.height, self.width = self._grids[0].shape
        north = south + (self.height - 0.5) * height
        self.transform = Affine(width, 0.0, west - 0.5 * width, 0.0, -height, north)
        code = file.attrs.get("horizontalCRS", file.attrs.get("horizontalDatumValue"))
        self.crs = None if code is None else CRS.from_epsg(int(code))
        self.count = len(names)
        self.dtypes, self.units = ("float32",) * self.count, ("metre",) * self.count
        self.scales, self.offsets = (1.0,) * self.count, (0.0,) * self.count

    def read_masks(self, band: int) -> Any:
        """Return 255 where a band has a depth, else 0, rows from the north."""
        return np.where(self._grids[band - 1]["depth"][::-1] == np.float32(self._fill), 0, 255)

    def read(self, band: int, out_dtype: Any) -> Any:
        """Return the elevations of a band, rows from the north."""
        return -self._grids[band - 1]["depth"][::-1].astype(out_dtype)


def described(file: Any, band: int, most_cells: int) -> dict[str, Any]:
    """Return a file's attributes of the same names, and of a band that it has the masks and values, if not too many."""
    found: dict[str, Any] = {
        name: np.array(getattr(file, name))
        for name in ("driver", "width", "height", "count", "dtypes", "scales", "offsets")
    }
    found["units"] = np.array([unit or "" for unit in file.units], str)
    found["transform"] = np.array(file.transform[:6])
    found["crs"] = np.array(file.crs.to_wkt() if file.crs else "")
    if band <= file.count and file.width * file.height <= most_cells and "complex" not in file.dtypes[band - 1]:
        found["masks"], found["values"] = file.read_masks(band), file.read(band, out_dtype=np.float64)
    return found


def read(path: str, band: int, formats: list[str], most_cells: int, is_hdf5: bool) -> dict[str, Any]:
    """Return what `described` does. Raises ValueError."""
    try:
        with Env(), _opened_apart(path, formats, is_hdf5) as file:
            return described(file, band, most_cells)
    except MemoryError:
        raise
    except Exception as error:  # GDAL's and NumPy's
        raise ValueError(" ".join(str(error.__cause__ or error).split()) or type(error).__name__) from None
