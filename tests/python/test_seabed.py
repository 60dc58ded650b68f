"""Laws of the depth grid and of the orders of S-44."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwsim.survey.s44 import CONFIDENCE, ORDERS, best_order, share_within
from uwsim.survey.seabed import seabed_grid


@given(n=st.integers(1, 200), seed=st.integers(0, 1000), cell_m=st.sampled_from([0.2, 0.5, 3.0]))
def test_every_cell_holds_the_median_and_the_count_of_its_points(n, seed, cell_m):
    points = np.random.default_rng(seed).uniform(-4.0, 4.0, (n, 3)) + np.array([100.0, -50.0, -30.0])
    grid = seabed_grid(points, cell_m)
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


@pytest.mark.parametrize(
    ("points", "cell_m", "message"),
    [
        (np.empty((0, 3)), 1.0, "no points"),
        (np.zeros((1, 3)), 0.0, "cell_m = 0.0 m: must be positive"),
        (np.zeros((1, 3)), np.nan, "cell_m = nan m"),
        (np.full((1, 3), np.nan), 1.0, "must be finite"),
        (np.array([[0.0, 0, 0], [1e6, 1e6, 0]]), 0.1, r"makes 1e\+14 cells"),
    ],
)
def test_what_makes_no_grid_is_refused(points, cell_m, message):
    with pytest.raises(ValueError, match=message):
        seabed_grid(points, cell_m)


def test_the_vertical_uncertainty_of_the_orders():
    """sqrt(a^2 + (b d)^2), worked by hand at 0 and 100 m."""
    expected = {"Exclusive": (0.15, 0.764853), "Special": (0.25, 0.790569), "1a": (0.5, 1.392839), "2": (1.0, 2.507987)}
    for order in ORDERS:
        at_surface, deep = order.tvu_m(np.array([0.0, 100.0]))
        assert (at_surface, deep) == pytest.approx(expected.get(order.name, expected["1a"]), rel=1e-5)
        assert order.tvu_m(np.array([-3.0])) == at_surface


@pytest.mark.parametrize("depth_m", [0.0, 30.0, 300.0])
@pytest.mark.parametrize("at", range(len(ORDERS)))
def test_the_order_changes_where_its_limit_lies(depth_m, at):
    order = ORDERS[at]
    depths, limit_m = np.full(100, depth_m), order.tvu_m(np.array([depth_m]))[0]
    sign = np.where(np.arange(100) % 2, 1.0, -1.0)
    assert share_within(order, 0.999 * limit_m * sign, depths) == 1.0
    assert share_within(order, 1.001 * limit_m * sign, depths) == 0.0
    kept = best_order(0.999 * limit_m * sign, depths)
    assert kept.tvu_m(depths[:1]) == limit_m
    worse = best_order(1.001 * limit_m * sign, depths)
    assert worse is None if order.name == "2" else worse.a_m > order.a_m


def test_an_order_needs_95_of_100_cells():
    depths = np.full(100, 20.0)
    for bad, name in ((5, "Exclusive"), (6, "2"), (100, None)):
        errors = np.zeros(100)
        errors[:bad] = 1.05 if bad < 100 else 9.0  # at 20 m order 2 allows 1.10 m, order 1 0.56 m
        order = best_order(errors, depths)
        assert (order.name if order else None) == name
    assert pytest.approx(0.95) == CONFIDENCE


def test_nothing_to_judge_is_of_no_order():
    nothing = np.empty(0)
    assert best_order(nothing, nothing) is None
    assert np.isnan(share_within(ORDERS[0], nothing, nothing))
