"""Exports a depth grid as a GeoTIFF for GIS programs: median depth, count and, if it is known, uncertainty."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from affine import Affine
from rasterio.io import MemoryFile

from uwsim.base.atomic_file import write_atomically
from uwsim.mapping.depth_grid import DepthGrid
from uwsim.mapping.files.formats import GridFormat
from uwsim.mapping.files.georeference import Georeference

MIN_TILED_SIZE = 512


def write_depth_tiff(path: Path, grid: DepthGrid, place: Georeference) -> None:
    """Write float32 bands, rows from north to south: "depth" [m], positive down, nan in empty cells; and "count".

    A grid that states its uncertainty adds "uncertainty" [m], at 95 %, nan where it is unknown.
    Written atomically. Raises OSError.
    """
    rows, columns = grid.depth_m.shape
    west, _, _, north = grid.extent_m
    scale, (x, y) = place.units_per_m, place.origin
    cell = grid.cell_m * scale
    tiles = {"tiled": True, "blockxsize": 256, "blockysize": 256} if max(rows, columns) >= MIN_TILED_SIZE else {}
    with MemoryFile() as memory:
        with memory.open(
            driver="GTiff",
            width=columns,
            height=rows,
            count=2 if grid.uncertainty_m is None else 3,
            dtype="float32",
            nodata=float("nan"),
            crs=place.crs,
            transform=Affine(cell, 0.0, x + west * scale, 0.0, -cell, y + north * scale),
            compress="deflate",
            predictor=3,
            **tiles,
        ) as file:
            file.write(np.flipud(grid.depth_m).astype(np.float32), 1)
            file.write(np.flipud(grid.count).astype(np.float32), 2)
            file.set_band_description(1, "depth")
            file.set_band_description(2, "count")
            file.units = ("m", "") if grid.uncertainty_m is None else ("m", "", "m")
            if grid.uncertainty_m is not None:
                file.write(np.flipud(grid.uncertainty_m).astype(np.float32), 3)
                file.set_band_description(3, "uncertainty")
            file.update_tags(VERTICAL_DATUM="mean water surface of the simulated world, z = 0")
            file.update_tags(1, STATISTIC="median of the points in the cell", POSITIVE="down")
            file.update_tags(2, STATISTIC="number of points in the cell")
            if place.crs is None:
                file.update_tags(HORIZONTAL="metres east and north of the simulated world's origin")
            if scale != 1.0:
                file.update_tags(SIMULATED_METRES="depths are simulated metres; a unit of x and y is not one of them")
        content = bytes(memory.read())
    write_atomically(path, content)


GEOTIFF = GridFormat(write_depth_tiff)
