"""Slices through a map, differences between two maps, and `uwsim map slice` and `diff`."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from pool_maps import VOXEL_M, read_figure, uwsim_map, write_pool_maps
from uwsim.cli.map import app
from uwsim.mapping import OccupancyMap
from uwsim.mapping.changes import map_difference
from uwsim.mapping.info import slice_map


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_pool_maps(tmp_path_factory.mktemp("maps"))


def test_a_difference_counts_every_voxel_once(folder, tmp_path):
    whole, part = OccupancyMap.read(folder / "pool.bt"), OccupancyMap.read(folder / "part.bt")
    found = map_difference(whole, part)
    counts = {
        name: (m.statistics().occupied_voxels, m.statistics().free_voxels) for name, m in (("w", whole), ("p", part))
    }
    assert tuple(found.counts[:2].sum(axis=1)) == counts["w"]
    assert tuple(found.counts[:, :2].sum(axis=0)) == counts["p"]
    assert found.counts[0, 2] > 0
    assert len(found.only_first_m) == found.counts[0, 1:].sum()
    assert len(found.only_second_m) == found.counts[1:, 0].sum()
    assert len(found.both_m) == found.counts[0, 0]
    assert np.array_equal(map_difference(part, whole).counts, found.counts.T)
    shown = uwsim_map("diff", folder / "pool.bt", folder / "part.bt", "--out", tmp_path / "d.png")
    assert f"{found.differing:,} voxels differ" in shown
    read_figure(tmp_path / "d.png")
    values = json.loads(uwsim_map("diff", folder / "pool.bt", folder / "part.bt", "--json"))
    assert values["counts"] == found.counts.tolist() and values["differing"] == found.differing


def test_a_map_does_not_differ_from_itself_and_the_exit_code_says_so(folder):
    runner = CliRunner()
    same = ["diff", str(folder / "pool.bt"), str(folder / "pool.ot"), "--exit-code"]
    assert "the states of all voxels are the same" in uwsim_map(*same)
    other = [*same[:2], str(folder / "part.bt"), "--exit-code"]
    assert runner.invoke(app, other).exit_code == 1
    assert runner.invoke(app, other[:-1]).exit_code == 0


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
