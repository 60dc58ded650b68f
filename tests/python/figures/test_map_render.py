"""Maps drawn in 3D, and `uwsim map render`."""

from pathlib import Path

import numpy as np
import pytest

from pool_maps import VOXEL_M, read_figure, uwsim_map, write_pool_maps
from uwsim.figures import map_render
from uwsim.mapping import OccupancyMap
from uwsim.mapping.info import occupied_cubes


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_pool_maps(tmp_path_factory.mktemp("maps"))


def test_a_map_is_drawn_in_colour_and_reproducibly(folder, tmp_path):
    for name in ("a.png", "b.png"):
        uwsim_map("render", folder / "pool.bt", "--out", tmp_path / name, "--width", "400")
    image = read_figure(tmp_path / "a.png")
    assert image.shape[1] >= 380
    assert (np.ptp(image.astype(int), axis=2) > 60).mean() > 0.1, "the cubes are in colour"
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_map_of_too_many_voxels_is_drawn_in_larger_cubes(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(map_render, "MAX_CUBES", 500)
    centres, edge_m = occupied_cubes(OccupancyMap.read(folder / "pool.bt", (0.1, 0.2, 0.3)), "pool", 500)
    assert len(centres) <= 500
    assert edge_m > VOXEL_M
    uwsim_map("render", folder / "pool.bt", "--out", tmp_path / "a.png", "--width", "300")
    read_figure(tmp_path / "a.png")
