"""Raster files of heights: a raster on its grid, its file, opened, and the unit and the gaps of its numbers."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from affine import Affine
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.env import Env
from rasterio.errors import NotGeoreferencedWarning
from rasterio.io import DatasetReader
from rasterio.warp import transform

from uwsim.base.extras import need_extra
from uwsim.base.texts.text_file import first_bytes, require_regular
from uwsim.mapping.files.georeference import WGS84, metres_about
from uwsim.scenario.read import raster_process
from uwsim.scenario.read.contained import run_contained
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.netcdf_file import CLASSIC, SIGNATURE
from uwsim.scenario.spec.terrain import MAX_NODES

if TYPE_CHECKING:
    from uwsim.scenario.terrains.raster import RasterTerrain


FloatGrid = NDArray[np.float64]
Coordinates = TypeVar("Coordinates", float, FloatGrid)
TRUE_TO_SCALE = 1e-3
"""A projection whose scale is within this share of 1, as those of surveys are, has metres that count as real ones."""


def mapped(affine: Affine, x: Coordinates, y: Coordinates) -> tuple[Coordinates, Coordinates]:
    """Return an affine map of coordinates."""
    return affine.a * x + affine.b * y + affine.c, affine.d * x + affine.e * y + affine.f


@dataclass(frozen=True)
class Raster:
    """A raster read from a file.

    elevations: (h, w) [m]; NaN for cells without data. file_from_pixel: transform from pixel corners (column, row) to
    the file's coordinates. names_crs: whether the file or the scenario does; without it, crs is a guess.
    """

    name: str
    elevations: FloatGrid
    file_from_pixel: Affine
    crs: CRS | None
    names_crs: bool = True

    @property
    def unit_m(self) -> float:
        """Metres per unit of a projected coordinate system, whose unit may be feet; 1 for others."""
        return float(self.crs.linear_units_factor[1]) if self.crs is not None and self.crs.is_projected else 1.0

    @property
    def is_geographic(self) -> bool:
        """Whether the coordinates are longitude and latitude in degrees."""
        return self.crs is not None and bool(self.crs.is_geographic)

    def metres_about(self, centre: tuple[float, float]) -> CRS | None:
        """Return the projection to metres about a place, or None where the file's own coordinates are true to scale."""
        if self.crs is None:
            return None
        if self.is_geographic:
            return metres_about(centre)
        longitude, latitude = (float(each[0]) for each in transform(self.crs, WGS84, [centre[0]], [centre[1]]))
        if not np.isfinite([longitude, latitude]).all():
            raise ScenarioError(
                f"terrain.centre = ({centre[0]:.9g}, {centre[1]:.9g}): '{self.name}' has no longitude there",
                at=("centre",),
            )
        about, step = metres_about((longitude, latitude)), 100.0 / self.unit_m
        x, y = transform(self.crs, about, centre[0] + step * np.eye(3)[0], centre[1] + step * np.eye(3)[1])
        sides = np.array([np.subtract(each[:2], each[2]) for each in (x, y)]) / 100.0
        true = np.abs(np.linalg.svd(sides, compute_uv=False) - 1.0).max() <= TRUE_TO_SCALE
        return None if true else about

    def safe_cell_m(self, centre: tuple[float, float]) -> float:
        """Return the largest edge [m] such that a square of n of them lies within n x n cells about a place."""
        about, unit = self.metres_about(centre), self.unit_m
        column, row = self.corner_at(*centre)
        x, y = self.place_at(column + np.eye(3)[0], row + np.eye(3)[1])
        east, north = (unit * x, unit * y) if about is None else transform(self.crs, about, x, y)
        sides = np.array([np.subtract(each[:2], each[2]) for each in (east, north)])
        return 1.0 / float(np.abs(np.linalg.inv(sides)).sum(axis=1).max())

    def pixel_at(self, x: FloatGrid, y: FloatGrid) -> tuple[FloatGrid, FloatGrid]:
        """Convert the file's coordinates to fractional columns and rows; whole numbers are cell centres."""
        columns, rows = mapped(~self.file_from_pixel, x, y)
        return columns - 0.5, rows - 0.5

    def corner_at(self, x: float, y: float) -> tuple[float, float]:
        """Convert the file's coordinates to fractional columns and rows; whole numbers are corners of cells."""
        return mapped(~self.file_from_pixel, x, y)

    def place_at(self, column: Coordinates, row: Coordinates) -> tuple[Coordinates, Coordinates]:
        """Convert columns and rows, as of `corner_at`, to the file's coordinates."""
        return mapped(self.file_from_pixel, column, row)


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


UNITS_M = {"m": 1.0, "ft": 0.3048, "us-ft": 1200.0 / 3937.0}
"""Metres per unit, by the names that a scenario may give."""
SPELLINGS_M = {
    "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001,
    "centimetre": 0.01, "centimetres": 0.01, "centimeter": 0.01, "centimeters": 0.01, "km": 1000.0,
    "ft": UNITS_M["ft"], "foot": UNITS_M["ft"], "feet": UNITS_M["ft"], "international foot": UNITS_M["ft"],
    "us-ft": UNITS_M["us-ft"], "ft-us": UNITS_M["us-ft"], "ftus": UNITS_M["us-ft"], "us_ft": UNITS_M["us-ft"],
    "us survey foot": UNITS_M["us-ft"], "us survey feet": UNITS_M["us-ft"], "foot_us": UNITS_M["us-ft"],
    "fathom": 1.8288, "fathoms": 1.8288,
}  # fmt: skip
"""Metres per unit, by the spellings of files. A text such as "metres above MSL" counts by its first word."""
VERTICAL = re.compile(r'VERT(?:_CS|CRS|ICALCRS)\[.*?(?:LENGTH)?UNIT\["([^"]*)",\s*([-+.\deE]+)', re.DOTALL)
GAP = re.compile(r"-?(9{2,}(\.9+)?|999\.25|3276[78])")
"""Numbers that files use for cells without data."""


def height_unit_m(file: DatasetReader, crs: CRS | None, spec: RasterTerrain) -> float:
    """Return metres per unit of a band's heights: that of the scenario, of the band, or of its vertical reference.

    Without any, they are metres, unless the file's horizontal unit is another. Raises ScenarioError where the unit
    has to be asked for.
    """
    if spec.unit is not None:
        return UNITS_M[spec.unit]
    ask = f"give their unit as unit, {', '.join(UNITS_M)} (`uwsim scenario from`: --unit)"
    stated = (file.units[(spec.band or 1) - 1] or "").strip()
    text = stated.strip("[]() ").replace("U.S.", "US").lower()
    if text:
        found = SPELLINGS_M.get(text) or SPELLINGS_M.get(text.split()[0])
        if found is None:
            raise ScenarioError(f"terrain '{spec.file.name}': its heights are in '{stated[:40]}': {ask}", at=("file",))
        return found
    if crs is None:
        return 1.0
    vertical = VERTICAL.search(crs.to_wkt())
    if vertical is not None:
        return float(vertical[2])
    name, factor = crs.linear_units_factor if crs.is_projected else ("metre", 1.0)
    if abs(factor - 1.0) > 1e-6:
        raise ScenarioError(
            f"terrain '{spec.file.name}': its eastings and northings are in '{name}', and the file does not state the "
            f"unit of its heights: {ask}",
            at=("file",),
        )
    return 1.0


def without_gaps(values: FloatGrid, spec: RasterTerrain) -> FloatGrid:
    """Return the values with NaN where the scenario's `nodata` is. Raises ScenarioError for another likely gap.

    Likely is a number that files use for gaps, such as -9999, and that is farther from all others than they are spread.
    """
    if spec.nodata is not None:
        return np.where(np.isclose(values, spec.nodata, rtol=1e-6, atol=0.0), np.nan, values)
    known = values[np.isfinite(values)]
    for value in {float(known.min()), float(known.max())} if known.size else ():
        if not GAP.fullmatch(f"{value:.7g}"):
            continue
        others = known[known != value]
        if others.size and np.abs(others - value).min() > np.ptp(others):
            raise ScenarioError(
                f"terrain '{spec.file.name}': {known.size - others.size} of {known.size} cells are {value:.7g}, far "
                f"from all others ({others.min():.6g} to {others.max():.6g}), and the file does not declare it as "
                f"no data: if it is, give nodata: {value:.7g} (`uwsim scenario from`: --nodata {value:.7g}); if it is "
                "a height, give another number",
                at=("file",),
            )
    return values
