"""HDF5 from anywhere: nothing outside of the file is read, and no more than a file of its size may hold."""

import os
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from uwsim import ScenarioError
from uwsim.scenario.read.hdf5_process import FREE_BYTES
from uwsim.scenario.read.ocean_file import read_ocean

h5py = pytest.importorskip("h5py")


def read_terrain(path: Path) -> object:
    pytest.importorskip("rasterio")
    from uwsim.scenario.terrains.elevations import raster_heights
    from uwsim.scenario.terrains.raster import RasterTerrain

    return raster_heights(RasterTerrain(source="raster", file=path, spacing_m=1.0, water_level_m=0.0))


READERS = {"sea.nc": read_ocean, "bed.nc": read_terrain}
NEEDED = {"sea.nc": "depth", "bed.nc": "Band1"}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("way", ["an external link", "a soft link", "external storage", "a virtual dataset"])
def test_nothing_leads_out_of_a_file(tmp_path: Path, name: str, way: str) -> None:
    """Into a pipe that is never written, which would stop the reader for good, even for SIGTERM."""
    os.mkfifo(tmp_path / "pipe")
    needed = NEEDED[name]
    with h5py.File(tmp_path / name, "w") as data:
        if way == "an external link":
            data[needed] = h5py.ExternalLink("pipe", "values")
        elif way == "a soft link":
            data["elsewhere"] = h5py.ExternalLink("pipe", "values")
            data[needed] = h5py.SoftLink("/elsewhere")
        elif way == "external storage":
            data.create_dataset(needed, (4, 4), "f4", external=[(str(tmp_path / "pipe"), 0, 64)])
        else:
            layout = h5py.VirtualLayout((4, 4), "f4")
            layout[:] = h5py.VirtualSource(str(tmp_path / "pipe"), "values", (4, 4))
            data.create_virtual_dataset(needed, layout)
    with pytest.raises(ScenarioError, match="must be in the file itself"):
        READERS[name](tmp_path / name)


def of_zeros(path: Path, axes: tuple[int, ...], **compressed: object) -> None:
    """An ocean field that was never written: any size in a few kB."""
    names = {"time": "s", "depth": "m", "latitude": "degrees_north", "longitude": "degrees_east"}
    with h5py.File(path, "w") as data:
        for (axis, unit), count in zip(names.items(), axes, strict=True):
            data[axis] = np.arange(float(count))
            data[axis].attrs["units"] = unit
            data[axis].make_scale(axis)
        speed = data.create_dataset("eastward_sea_water_velocity", axes, "f4", maxshape=(None,) * 4, **compressed)
        speed.attrs["units"] = "m s-1"
        for k, axis in enumerate(names):
            speed.dims[k].attach_scale(data[axis])
        for k in range(20):  # not needed
            data.create_dataset(f"other_{k}", (40_000_000,), "f8", chunks=(1_000_000,), compression="gzip")


def test_sizes_are_bounded_before_anything_is_read(tmp_path: Path) -> None:
    of_zeros(tmp_path / "sea.nc", (100, 20, 100, 100), compression="gzip", chunks=(1, 20, 100, 100))

    def refused() -> None:
        with pytest.raises(ScenarioError, match="20,000,000 values, too many for a file of this size"):
            read_ocean(tmp_path / "sea.nc")

    assert peak(refused) < 2 * FREE_BYTES


def test_a_chunk_of_any_size_is_unpacked_within_the_limits_of_a_process(tmp_path: Path) -> None:
    of_zeros(tmp_path / "sea.nc", (1, 2, 2, 2), compression="gzip", chunks=(500, 100, 100, 100))
    assert peak(lambda: read_ocean(tmp_path / "sea.nc")) < FREE_BYTES


def test_what_is_not_needed_is_not_read(tmp_path: Path) -> None:
    of_zeros(tmp_path / "sea.nc", (1, 2, 2, 2), compression="gzip")
    assert peak(lambda: read_ocean(tmp_path / "sea.nc")) < FREE_BYTES


def peak(read: Callable[[], object]) -> int:
    """The most memory that Python and NumPy held meanwhile."""
    tracemalloc.start()
    try:
        read()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
