"""Exports a depth grid as a Bathymetric Attributed Grid (BAG 1.6), by GDAL: elevation and uncertainty."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
from affine import Affine
from rasterio.io import MemoryFile
from rasterio.shutil import copy

from uwsim.base.atomic_file import write_atomically
from uwsim.mapping.depth_grid import DepthGrid
from uwsim.mapping.files.formats import GridFormat
from uwsim.mapping.files.georeference import Georeference

NO_DATA = np.float32(1e6)  # as the format has it
METADATA = {
    "VAR_TITLE": "Depth grid", "VAR_ABSTRACT": "Gridded by uwsim: of a simulated survey, no real sea floor",
    "VAR_INDIVIDUAL_NAME": "uwsim", "VAR_ORGANISATION_NAME": "uwsim", "VAR_POSITION_NAME": "simulator",
    "VAR_DATE": "2020-01-01", "VAR_DATETIME": "2020-01-01T00:00:00",
    "VAR_VERTICAL_DATUM": "mean water surface", "VAR_PROCESS_STEP_DESCRIPTION": "median of the points in each cell",
}  # fmt: skip

CHANGED = re.compile(rb"(\x12\0\x08\0.\0{3}\x01\0{3}).{4}", re.DOTALL)
"""The modification time of an HDF5 object: message type 0x12 of 8 bytes, flags, version 1, and the time [s] (HDF5 File
Format Specification, IV.A.2.s). GDAL enters the current time."""

THEN = (1_577_836_800).to_bytes(4, "little")  # VAR_DATETIME


def write_bag(path: Path, grid: DepthGrid, place: Georeference) -> None:
    """Write elevations, positive up, and their uncertainty: as the grid states it, else half a cell.

    Empty cells have no data. Written atomically. Raises OSError, or ValueError without a place on Earth.
    """
    if place.crs is None:
        raise ValueError(f"{path}: a BAG needs a place on Earth: give --scenario, of one with earth or a georeferenced "
                         "terrain")  # fmt: skip
    rows, columns = grid.depth_m.shape
    west, _, _, north = grid.extent_m
    scale, (x, y) = place.units_per_m, place.origin
    cell = grid.cell_m * scale
    depth = np.flipud(grid.depth_m)
    known = np.isfinite(depth)
    error = np.where(known, 0.5 * grid.cell_m, np.nan) if grid.uncertainty_m is None else np.flipud(grid.uncertainty_m)
    layers = np.stack([np.where(np.isfinite(each), each, NO_DATA) for each in (-depth, error)])
    kind = "unknown" if grid.uncertainty_m is None else "productUncert"
    with MemoryFile() as memory, tempfile.TemporaryDirectory() as folder:
        with memory.open(
            driver="GTiff", width=columns, height=rows, count=2, dtype="float32", nodata=float(NO_DATA), crs=place.crs,
            transform=Affine(cell, 0.0, x + west * scale, 0.0, -cell, y + north * scale),
        ) as file:  # fmt: skip
            file.write(layers.astype(np.float32))
        made = Path(folder) / "grid.bag"
        with memory.open() as file:
            copy(file, str(made), driver="BAG", VAR_VERTICAL_UNCERT_CODE=kind, **METADATA)
        content = made.read_bytes()
    write_atomically(path, CHANGED.sub(lambda found: found[1] + THEN, content))


BAG = GridFormat(write_bag)
