"""The format `.asc` of depth grids, ESRI's ASCII grid."""

import io
from pathlib import Path

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.mapping.depth_grid import DepthGrid
from uwsim.mapping.files.formats import GridFormat
from uwsim.mapping.files.georeference import Georeference


def write(path: Path, grid: DepthGrid, place: Georeference) -> None:
    """Write the depths, the northernmost row first."""
    rows, columns = grid.depth_m.shape
    scale, (x, y) = place.units_per_m, place.origin
    text = io.StringIO()
    text.write(f"ncols {columns}\nnrows {rows}\nxllcorner {x + grid.west_m * scale}\n")
    text.write(f"yllcorner {y + grid.south_m * scale}\ncellsize {grid.cell_m * scale}\nnodata_value nan\n")
    np.savetxt(text, np.flipud(grid.depth_m), "%g")
    write_atomically(path, text.getvalue().encode())


ASC = GridFormat(write)
