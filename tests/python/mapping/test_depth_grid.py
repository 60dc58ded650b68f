"""Properties of the depth grid."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uwsim.mapping.depth_grid import depth_grid


@settings(max_examples=30)
@given(n=st.integers(1, 200), seed=st.integers(0, 1000), cell_m=st.sampled_from([0.2, 0.5, 3.0]))
def test_every_cell_holds_the_median_and_the_count_of_its_points(n, seed, cell_m):
    points = np.random.default_rng(seed).uniform(-4.0, 4.0, (n, 3)) + np.array([100.0, -50.0, -30.0])
    grid = depth_grid(points, cell_m)
    assert grid.count.sum() == n
    columns = np.floor((points[:, 0] - grid.west_m) / cell_m + 1e-9).astype(int)
    rows = np.floor((points[:, 1] - grid.south_m) / cell_m + 1e-9).astype(int)
    for row, column in np.ndindex(grid.count.shape):
        mine = -points[(rows == row) & (columns == column), 2]
        assert grid.count[row, column] == len(mine)
        if len(mine):
            assert grid.depth_m[row, column] == pytest.approx(np.median(mine))
        else:
            assert np.isnan(grid.depth_m[row, column])
    west, east, south, north = grid.extent_m
    assert west <= points[:, 0].min()
    assert points[:, 0].max() <= east + 1e-9
    assert south <= points[:, 1].min()
    assert points[:, 1].max() <= north + 1e-9
    assert west / cell_m == pytest.approx(round(west / cell_m))


def test_a_cells_uncertainty_is_the_greater_of_what_its_points_state_and_their_spread():
    draw = np.random.default_rng(7)
    points = draw.uniform(0.0, 5.0, (400, 3))
    stated = np.where(draw.uniform(size=400) < 0.3, np.nan, draw.uniform(0.1, 3.0, 400))
    grid = depth_grid(points, 1.0, stated)
    for row, column in np.ndindex(grid.depth_m.shape):
        mine = (np.floor(points[:, 0]) == column) & (np.floor(points[:, 1]) == row)
        known = stated[mine & np.isfinite(stated)]
        expected = 1.96 * max(np.sqrt(np.mean(known**2)), np.std(points[mine, 2], ddof=1))
        assert grid.uncertainty_m[row, column] == pytest.approx(expected)
    alone = depth_grid(np.array([[0.5, 0.5, -1.0], [2.5, 0.5, -1.0]]), 1.0, np.array([0.5, np.nan])).uncertainty_m
    np.testing.assert_allclose(alone, [[0.98, np.nan, np.nan]])


@pytest.mark.parametrize(
    ("points", "cell_m", "message"),
    [
        (np.empty((0, 3)), 1.0, "no points"),
        (np.zeros((1, 3)), 0.0, "cell_m = 0.0 m: must be positive"),
        (np.zeros((1, 3)), np.nan, "cell_m = nan m"),
        (np.full((1, 3), np.nan), 1.0, "must be finite"),
        (np.array([[0.0, 0, 0], [1e6, 1e6, 0]]), 0.1, r"gives 1e\+14 cells"),
    ],
)
def test_invalid_points_and_cells_are_refused(points, cell_m, message):
    with pytest.raises(ValueError, match=message):
        depth_grid(points, cell_m)


def test_gdal_reads_the_bag_that_we_write(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    from uwsim.mapping.files.bag import write_bag
    from uwsim.mapping.files.georeference import Georeference, metres_about

    points = np.array([[0.5, 0.5, -10.0], [2.5, 1.5, -12.5], [2.6, 1.4, -12.7]])
    place = Georeference(metres_about((5.9, 43.1)))
    for name in ("a.bag", "b.bag"):
        write_bag(tmp_path / name, depth_grid(points, 1.0), place)
        time.sleep(1.1)  # times in HDF5 files are in seconds
    assert (tmp_path / "a.bag").read_bytes() == (tmp_path / "b.bag").read_bytes()
    with rasterio.open(tmp_path / "a.bag") as file:
        assert (file.driver, file.descriptions) == ("BAG", ("elevation", "uncertainty"))
        found = file.read(1, masked=True)
        np.testing.assert_allclose(found[~found.mask], [-12.6, -10.0], atol=1e-6)
        assert file.index(2.5, 1.5) == (0, 2) and file.index(0.5, 0.5) == (1, 0)
        assert found.mask.sum() == found.size - 2
    with pytest.raises(ValueError, match="needs a place on Earth"):
        write_bag(tmp_path / "c.bag", depth_grid(points, 1.0), Georeference())
