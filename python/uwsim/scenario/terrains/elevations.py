"""Terrain derived from an elevation raster: GeoTIFF, ESRI ASCII grid or any other format that GDAL can read."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from affine import Affine
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.errors import CRSError, RasterioError
from rasterio.fill import fillnodata
from rasterio.warp import transform

from uwsim.base.caught_warnings import warn_if_cut_short
from uwsim.mapping.files.georeference import WGS84, Georeference
from uwsim.scenario.build.terrain import SPLINE_MARGIN, grid_axes, pixel_ranges, resampled
from uwsim.scenario.build.whole_tiff import require_whole_tiff
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.netcdf_file import require_whole_netcdf
from uwsim.scenario.spec.terrain import LOCAL, MAX_NODES
from uwsim.scenario.terrains.raster_file import Raster, height_unit_m, mapped, opened, without_gaps

if TYPE_CHECKING:
    from uwsim.scenario.terrains.raster import RasterTerrain

FloatGrid = NDArray[np.float64]
MAX_HEIGHT_M = 12_000.0
"""Largest distance from the water surface; no sea is deeper."""
DEGREE_CELL = 0.1
"""If a file has no coordinate system, cells smaller than this that lie on the globe are assumed to be in degrees."""
WHOLE = {"GTiff": require_whole_tiff, "netCDF": require_whole_netcdf}
"""By GDAL's name: checks of formats whose missing parts GDAL reads as zeros."""
GRID_HEADER = (b"ncols", b"nrows", b"xllcorner", b"xllcenter", b"yllcorner", b"yllcenter", b"cellsize", b"dx", b"dy")
GRID_NUMBER = re.compile(rb"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
GRID_BYTES = b"0123456789+-.eE \t\r\n\f\v"


def chart_raster(spec: RasterTerrain) -> Raster:
    """Return the raster of a terrain as it is in its file. Raises ScenarioError."""
    return _read(spec)


def raster_heights(spec: RasterTerrain) -> FloatGrid:
    """Return heights (ny, nx), (elevation - water_level_m) * vertical_scale, on a metric grid about the centre."""
    raster = _read(spec)
    h, w = raster.elevations.shape
    centre = spec.centre or mapped(raster.file_from_pixel, w / 2, h / 2)
    _require_centre(raster, centre, spec)
    about = raster.metres_about(centre)
    size = spec.size_m or _largest_size(raster, centre, about, spec)
    margin = 0.5 + 1e-6  # a cell's value extends to its edge

    def pixel_at(x: FloatGrid, y: FloatGrid) -> tuple[FloatGrid, FloatGrid]:
        columns, rows = raster.pixel_at(
            *_file_from_metres(raster, centre, about, x / spec.horizontal_scale, y / spec.horizontal_scale)
        )
        outside = (columns < -margin) | (columns > w - 1 + margin) | (rows < -margin) | (rows > h - 1 + margin)
        if outside.any() or not np.isfinite(columns + rows).all():
            raise ScenarioError(
                f"terrain '{raster.name}': {size[0]:g} x {size[1]:g} m at horizontal_scale {spec.horizontal_scale:g} "
                f"about ({centre[0]:.6g}, {centre[1]:.6g}) reaches beyond the raster: choose a smaller size_m or "
                "another centre"
            )
        return rows, columns

    axes = grid_axes(size, spec.spacing_m)
    top, left, part = 0, 0, raster.elevations
    if np.isnan(part).any():  # there may be gaps outside the terrain, as in a survey of a strip
        (top, bottom), (left, right) = pixel_ranges(*axes, pixel_at)
        _require_no_gaps(raster.name, part[top : bottom + 1, left : right + 1])
        top, left = max(top - SPLINE_MARGIN, 0), max(left - SPLINE_MARGIN, 0)
        part = _filled(part[top : bottom + SPLINE_MARGIN + 1, left : right + SPLINE_MARGIN + 1])

    def part_pixel_at(x: FloatGrid, y: FloatGrid) -> tuple[FloatGrid, FloatGrid]:
        rows, columns = pixel_at(x, y)
        return rows - top, columns - left

    return _heights(raster, resampled(part, *axes, part_pixel_at, spec.interpolation), spec)


def raster_place(spec: RasterTerrain) -> Georeference:
    """Return the location of a raster terrain, in its projection to metres if it has one."""
    raster = _read(spec)
    h, w = raster.elevations.shape
    centre = spec.centre or mapped(raster.file_from_pixel, w / 2, h / 2)
    if (about := raster.metres_about(centre)) is not None:
        return Georeference(about, (0.0, 0.0), 1.0 / spec.horizontal_scale)
    return Georeference(raster.crs, centre, 1.0 / (raster.unit_m * spec.horizontal_scale))


def _require_centre(raster: Raster, centre: tuple[float, float], spec: RasterTerrain) -> None:
    h, w = raster.elevations.shape
    column, row = mapped(~raster.file_from_pixel, *centre)
    if not (0 <= column <= w and 0 <= row <= h):
        (x0, y0), (x1, y1) = (mapped(raster.file_from_pixel, *corner) for corner in ((0.0, h), (w, 0.0)))
        raise ScenarioError(
            f"terrain.centre = ({centre[0]:.9g}, {centre[1]:.9g}): outside '{raster.name}', which reaches from "
            f"({x0:.9g}, {y0:.9g}) to ({x1:.9g}, {y1:.9g}) in its own coordinates",
            at=("centre",),
        )
    if raster.is_geographic and abs(centre[1]) >= 90:
        raise ScenarioError(
            f"terrain.crs: '{raster.name}' is read as degrees, but the latitude of its middle is {centre[1]:g}: must "
            f"be between -90 and 90; give its coordinate system as crs ({LOCAL} for metres)",
            at=("crs",) if spec.crs else ("file",),
        )


def _heights(raster: Raster, elevations: FloatGrid, spec: RasterTerrain) -> FloatGrid:
    """Return scaled elevations above the water. Raises ScenarioError for any beyond MAX_HEIGHT_M."""
    above = elevations - spec.water_level_m
    heights = above * spec.vertical_scale
    if np.abs(heights).max() <= MAX_HEIGHT_M:
        return heights
    makes = f"heights from {heights.min():.6g} to {heights.max():.6g} m: must be within {MAX_HEIGHT_M:g} m of the water"
    if np.abs(above).max() <= MAX_HEIGHT_M:
        raise ScenarioError(f"terrain.vertical_scale = {spec.vertical_scale:g}: makes {makes}", at=("vertical_scale",))
    raise ScenarioError(
        f"terrain '{raster.name}': elevations from {elevations.min():.6g} to {elevations.max():.6g} make {makes} "
        "(cells without data that are not marked as such: nodata? water_level_m? unit?)",
        at=("file",),
    )


def _read(spec: RasterTerrain) -> Raster:
    name = spec.file.name
    try:
        with opened(spec.file, spec.band or 1) as file:
            if file.driver in WHOLE:
                _require_whole(spec.file, WHOLE[file.driver])
            if file.driver == "AAIGrid":
                _require_numbers(spec.file, file.width * file.height)
                warn_if_cut_short(f"terrain '{name}'", spec.file.read_bytes())
            if file.count != 1 and spec.band is None:
                raise ScenarioError(f"terrain '{name}': {file.count} bands, expected 1 (choose one with band)")
            if (spec.band or 1) > file.count:
                raise ScenarioError(f"terrain '{name}': band = {spec.band}: the file has {file.count}")
            if "complex" in file.dtypes[(spec.band or 1) - 1]:
                raise ScenarioError(f"terrain '{name}': holds complex numbers, expected elevations", at=("file",))
            if file.width * file.height > 4 * MAX_NODES:
                raise ScenarioError(
                    f"terrain '{name}': {file.width} x {file.height} cells, must be at most {4 * MAX_NODES}"
                )
            if min(file.width, file.height) < 2:
                raise ScenarioError(f"terrain '{name}': {file.width} x {file.height} cells, expected 2 x 2 or more")
            band = spec.band or 1
            values = np.where(file.read_masks(band) > 0, file.read(band, out_dtype=np.float64), np.nan)
            file_from_pixel, crs = file.transform, _crs(spec, file.crs, file.transform)
            names_crs = spec.crs is not None or file.crs is not None
            unit_m = height_unit_m(file, crs, spec)
            scale, offset = file.scales[band - 1], file.offsets[band - 1]  # of packed heights
    except RasterioError as error:
        raise ScenarioError(f"terrain '{name}': not a readable elevation raster: {_reason(error)}") from None
    if file_from_pixel.is_degenerate or file_from_pixel.is_identity:
        raise ScenarioError(f"terrain '{name}': has no position or size of its cells (for an image: source: image)")
    if crs is not None and not (crs.is_geographic or crs.is_projected):
        raise ScenarioError(
            f"terrain.crs: that of '{name}' is neither geographic nor projected: give crs: {LOCAL} if it is in metres",
            at=("crs",) if spec.crs else ("file",),
        )
    known = without_gaps(np.where(np.isfinite(values), values, np.nan), spec)
    elevations = (known * scale + offset) * (-unit_m if spec.positive == "down" else unit_m)
    heights = _filled(elevations) if spec.fill_nodata else elevations
    return Raster(name, heights, file_from_pixel, crs, names_crs)


def _filled(elevations: FloatGrid) -> FloatGrid:
    """Return the elevations with their gaps interpolated, unless there are only gaps."""
    has_data = np.isfinite(elevations)
    if has_data.all() or not has_data.any():
        return elevations
    reach = float(np.hypot(*elevations.shape))
    filled = fillnodata(np.where(has_data, elevations, 0).astype(np.float32), has_data, max_search_distance=reach)
    return np.where(has_data, elevations, filled)


def _require_no_gaps(name: str, elevations: FloatGrid) -> None:
    gaps = np.count_nonzero(np.isnan(elevations))
    if gaps > 0:
        raise ScenarioError(
            f"terrain '{name}': {gaps} of the {elevations.size} cells that the terrain needs have no data "
            "(fill_nodata: true fills gaps; centre and size_m select a part)"
        )


def _crs(spec: RasterTerrain, crs: CRS | None, file_from_pixel: Affine) -> CRS | None:
    """Return the file's coordinate system, or None for plain metres."""
    if spec.crs == LOCAL:
        return None
    if spec.crs is None:
        looks_like_degrees = abs(file_from_pixel.a) < DEGREE_CELL and abs(file_from_pixel.c) <= 180 + DEGREE_CELL
        return crs or (CRS.from_string(WGS84) if looks_like_degrees else None)
    try:
        return CRS.from_user_input(spec.crs)
    except (CRSError, ValueError):
        raise ScenarioError(
            f"terrain.crs = '{spec.crs}': not a coordinate system, such as {WGS84} or {LOCAL}", at=("crs",)
        ) from None


def _file_from_metres(
    raster: Raster, centre: tuple[float, float], about: CRS | None, x_m: FloatGrid, y_m: FloatGrid
) -> tuple[FloatGrid, FloatGrid]:
    """Convert real metres east and north of the centre to the file's coordinates. about: their projection, if any."""
    if about is None:
        return centre[0] + x_m / raster.unit_m, centre[1] + y_m / raster.unit_m
    x, y = transform(about, raster.crs, x_m.ravel(), y_m.ravel())
    return np.reshape(x, x_m.shape), np.reshape(y, x_m.shape)


def _largest_size(
    raster: Raster, centre: tuple[float, float], about: CRS | None, spec: RasterTerrain
) -> tuple[float, float]:
    """Return the simulated size of the largest grid around the centre that fits within the outermost cell centres."""
    h, w = raster.elevations.shape
    across, down = np.linspace(0.5, w - 0.5, 65), np.linspace(0.5, h - 0.5, 65)
    columns = np.concatenate([across, across, np.full(65, 0.5), np.full(65, w - 0.5)])
    rows = np.concatenate([np.full(65, 0.5), np.full(65, h - 0.5), down, down])
    x, y = mapped(raster.file_from_pixel, columns, rows)
    if about is not None:
        east, north = (np.asarray(axis) for axis in transform(raster.crs, about, x, y))
    else:
        east, north = (x - centre[0]) * raster.unit_m, (y - centre[1]) * raster.unit_m
    # A border point limits the size along the axis on which it is relatively farther out.
    limits_east = np.abs(east) / np.ptp(east) > np.abs(north) / np.ptp(north)
    halves = np.abs(east[limits_east]).min(), np.abs(north[~limits_east]).min()
    cells = [int(2 * half * spec.horizontal_scale / spec.spacing_m) for half in halves]
    if min(cells) < 1 or (cells[0] + 1) * (cells[1] + 1) > MAX_NODES:
        raise ScenarioError(
            f"terrain '{raster.name}': {cells[0]} x {cells[1]} spacings of {spec.spacing_m:g} m at horizontal_scale "
            f"{spec.horizontal_scale:g}: must be at least 1 x 1 and at most {MAX_NODES}; set horizontal_scale or size_m"
        )
    return cells[0] * spec.spacing_m, cells[1] * spec.spacing_m


def _require_whole(path: Path, require_whole: Callable[[Path], None]) -> None:
    try:
        require_whole(path)
    except ValueError as error:
        raise ScenarioError(f"terrain '{path.name}': not a readable elevation raster: {error}") from None


def _require_numbers(path: Path, cells: int) -> None:
    """Raise ScenarioError for parts of an ASCII grid that GDAL would read as zero: words and missing numbers."""
    numbers = 0
    with path.open("rb") as lines:
        for number, line in enumerate(lines, 1):
            words = line.split()
            if line[:12].lower() == b"nodata_value":  # may be NaN
                continue
            if words and words[0].lower() in GRID_HEADER:
                words = words[1:2] or [b""]
            else:
                numbers += len(words)
            if _are_numbers(line, words):
                continue
            bad = next((word for word in words if not GRID_NUMBER.fullmatch(word)), None)
            if bad is not None:
                text = bad.decode("latin-1")
                raise ScenarioError(f"terrain '{path.name}': line {number}: '{text:.40}' is not a number")
    if numbers < cells:
        raise ScenarioError(f"terrain '{path.name}': {numbers} numbers for its {cells} cells: is the file cut short?")


def _are_numbers(line: bytes, words: list[bytes]) -> bool:
    """Return whether a row of a grid has only numbers, in less than half of the time that GRID_NUMBER takes."""
    if line.translate(None, GRID_BYTES):
        return False
    try:
        return all(map(math.isfinite, map(float, words)))
    except ValueError:
        return False


def _reason(error: Exception) -> str:
    cause = error.__cause__ or error
    return " ".join(str(cause).split())
