"""Charts of real places: readers of their formats for the fuzzers, and the small files with which these start."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np


def chart(suffix: str) -> Callable[[bytes, Path], Any]:
    """Return a reader of a chart: the scenario that is made of it."""

    def read(data: bytes, folder: Path) -> Any:
        from uwsim.exchange.charts import scenario_from_chart

        path, out = folder / f"chart{suffix}", folder / "made.yaml"
        path.write_bytes(data)
        made = scenario_from_chart(path, out, size_m=10.0)
        return [out.read_bytes(), made.depth_m]

    return read


def soundings(data: bytes, folder: Path) -> Any:
    """Read soundings as text, and grid them."""
    from uwsim.exchange.soundings import grid_soundings, read_soundings

    path, out = folder / "soundings.xyz", folder / "made.tif"
    path.write_bytes(data)
    found = read_soundings(path)
    return [found.points.tobytes(), grid_soundings(found, out, cell=None, crs=None), out.read_bytes()]


def sounded() -> list[bytes]:
    """Return soundings on a grid, and scattered ones with named columns."""
    grid = "".join(f"{k % 4} {k // 4} {-20 - k}\n" for k in range(16))
    rows = np.random.default_rng(1).uniform(0.0, 9.0, (40, 3)).round(2).tolist()
    return [grid.encode(), ("easting,northing,depth\n" + "".join(f"{x},{y},{z}\n" for x, y, z in rows)).encode()]


def made(suffix: str) -> Callable[[], list[bytes]]:
    """Return a maker of a small chart in a format that we write: 8 x 6 cells, one of them empty."""

    def make() -> list[bytes]:
        from uwsim.mapping.depth_grid import depth_grid
        from uwsim.mapping.files.formats import GRID_FORMATS
        from uwsim.mapping.files.georeference import Georeference, metres_about

        x, y = np.meshgrid(np.arange(8) + 0.5, np.arange(6) + 0.5)
        points = np.column_stack([x.ravel(), y.ravel(), -20.0 - x.ravel() - 0.5 * y.ravel()])[1:]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"chart{suffix}"
            GRID_FORMATS[suffix].write(path, depth_grid(points, 1.0), Georeference(metres_about((5.9, 43.1))))
            return [path.read_bytes()]

    return make


def s102(depths: np.ndarray[Any, Any], west_m: float, south_m: float, spacing_m: float) -> bytes:
    """Return what matters of S-102 3.0.0 (IHO, 2024): depths in rows from the south, positive down, in UTM zone 10."""
    import h5py

    rows, columns = depths.shape
    values = np.zeros((rows, columns), [("depth", "<f4")])
    values["depth"] = np.where(np.isfinite(depths), depths, 1e6)
    with h5py.File(memory := io.BytesIO(), "w") as file:
        file.attrs["productSpecification"] = "INT.IHO.S-102.3.0.0"
        file.attrs["horizontalCRS"] = np.int32(32610)
        file.create_group("Group_F")
        coverage = file.create_group("BathymetryCoverage").create_group("BathymetryCoverage.01")
        for axis, origin, count in (("Longitud", west_m, columns), ("Latitud", south_m, rows)):
            coverage.attrs[f"gridOrigin{axis}e"] = origin + 0.5 * spacing_m
            coverage.attrs[f"gridSpacing{axis}inal"] = spacing_m
            coverage.attrs[f"numPoints{axis}inal"] = np.uint32(count)
        coverage.attrs["startSequence"] = "0,0"
        coverage.create_group("Group_001").create_dataset("values", data=values)
    return memory.getvalue()


def surface() -> list[bytes]:
    """Return a small S-102: 8 x 6 cells, one of them empty."""
    depths = 20.0 + np.add.outer(0.5 * np.arange(6), np.arange(8))
    depths[0, 0] = np.nan
    return [s102(depths, 520_000.0, 5_330_000.0, 1.0)]


def elevations() -> list[bytes]:
    """Return elevations by latitude and longitude in classic NetCDF, as GEBCO has them."""
    from scipy.io import netcdf_file

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "chart.nc"
        with netcdf_file(path, "w") as file:
            for name, unit, first in (("lat", "degrees_north", 43.0), ("lon", "degrees_east", 5.0)):
                file.createDimension(name, 6)
                axis = file.createVariable(name, "d", (name,))
                axis[:], axis.units, axis.standard_name = first + np.arange(6) / 240, unit, f"{name}itude"
            bed = file.createVariable("elevation", "h", ("lat", "lon"))
            bed[:], bed.units = -20 - np.arange(36).reshape(6, 6), "m"
        return [path.read_bytes()]
