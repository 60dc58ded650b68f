"""Slices through a map, and `uwsim map slice`."""

from pathlib import Path

import numpy as np
import pytest

from pool_maps import VOXEL_M, read_figure, uwsim_map, write_pool_maps
from uwsim.mapping import OccupancyMap
from uwsim.mapping.slice import slice_map


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_pool_maps(tmp_path_factory.mktemp("maps"))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_slice_holds_the_states_of_its_layer(folder, tmp_path, axis):
    occupancy = OccupancyMap.read(folder / "pool.bt")
    at = {"x": 0.1, "y": -1.0, "z": -4.6}[axis]
    found = slice_map(occupancy, axis, at)
    normal = "xyz".index(axis)
    assert abs(found.at_m - at) <= VOXEL_M / 2 + 1e-9
    for voxels, state in ((occupancy.occupied_voxels(), 1), (occupancy.free_voxels(), 0)):
        assert np.count_nonzero(found.states == state) == np.count_nonzero(
            np.abs(voxels[:, normal] - found.at_m) < 0.01
        )
    west, _, south, _ = found.extent_m
    inside = occupancy.occupied_voxels()
    inside = np.delete(inside[np.abs(inside[:, normal] - found.at_m) < 0.01], normal, axis=1)
    columns, rows = np.floor((inside - [west, south]) / VOXEL_M).astype(int).T
    assert (found.states[rows, columns] == 1).all()
    uwsim_map("slice", folder / "pool.bt", f"--{axis}", at, "--out", tmp_path / "slice.png")
    read_figure(tmp_path / "slice.png")
