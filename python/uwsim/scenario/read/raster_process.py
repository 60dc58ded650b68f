"""Import of a raster by GDAL, in a process: python raster_process.py FILE BAND FORMATS CELLS BYTES CPU_S > parts.npz.

To start quickly, this must not import uwsim. stdout: what `described` returns.
"""

from __future__ import annotations

import os
import resource
import sys
from typing import Any

import numpy as np
from rasterio.env import Env
from rasterio.io import DatasetReader


def opened(path: str, formats: list[str]) -> DatasetReader:
    """Open a raster for reading, in one of GDAL's formats by name. Raises RasterioError."""
    file = DatasetReader(path, driver=formats)
    if file.driver != "S102":
        return file
    file.close()  # it holds depths, positive down
    return DatasetReader(path, driver=["S102"], DEPTH_OR_ELEVATION="ELEVATION")


def described(file: DatasetReader, band: int, most_cells: int) -> dict[str, Any]:
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


def main() -> None:
    """Read the band within the limits; on error, print one line to stderr and exit with code 1."""
    path, band, formats, most_cells = sys.argv[1], int(sys.argv[2]), sys.argv[3].split(","), int(sys.argv[4])
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # keeps the libraries' output out of the result
    for kind, limit in (
        (resource.RLIMIT_AS, int(sys.argv[5])),
        (resource.RLIMIT_CPU, int(sys.argv[6])),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (limit, limit))
    try:
        with Env(), opened(path, formats) as file:
            found = described(file, band, most_cells)
    except MemoryError:
        sys.exit(f"takes more than {int(sys.argv[5]) / 1e9:.1f} GB to read")
    except Exception as error:  # GDAL's and NumPy's
        sys.exit(" ".join(str(error.__cause__ or error).split()) or type(error).__name__)
    np.savez(out, **found)
    out.close()


if __name__ == "__main__":
    main()
