"""The vertical uncertainty orders of IHO S-44."""

import numpy as np
import pytest

from uwsim.scoring.s44 import CONFIDENCE, ORDERS, best_order, share_within


def test_the_vertical_uncertainty_follows_the_formula():
    """sqrt(a^2 + (b d)^2), calculated by hand for 0 and 100 m."""
    expected = {"Exclusive": (0.15, 0.764853), "Special": (0.25, 0.790569), "1a": (0.5, 1.392839), "2": (1.0, 2.507987)}
    for order in ORDERS:
        at_surface, deep = order.tvu_m(np.array([0.0, 100.0]))
        assert (at_surface, deep) == pytest.approx(expected.get(order.name, expected["1a"]), rel=1e-5)
        assert order.tvu_m(np.array([-3.0])) == at_surface


@pytest.mark.parametrize("depth_m", [0.0, 30.0, 300.0])
@pytest.mark.parametrize("at", range(len(ORDERS)))
def test_an_order_is_met_up_to_its_limit_and_not_beyond(depth_m, at):
    order = ORDERS[at]
    depths, limit_m = np.full(100, depth_m), order.tvu_m(np.array([depth_m]))[0]
    sign = np.where(np.arange(100) % 2, 1.0, -1.0)
    assert share_within(order, 0.999 * limit_m * sign, depths) == 1.0
    assert share_within(order, 1.001 * limit_m * sign, depths) == 0.0
    kept = best_order(0.999 * limit_m * sign, depths)
    assert kept.tvu_m(depths[:1]) == limit_m
    worse = best_order(1.001 * limit_m * sign, depths)
    assert worse is None if order.name == "2" else worse.a_m > order.a_m


def test_an_order_requires_95_of_100_cells():
    depths = np.full(100, 20.0)
    for bad, name in ((5, "Exclusive"), (6, "2"), (100, None)):
        errors = np.zeros(100)
        errors[:bad] = 1.05 if bad < 100 else 9.0  # at 20 m order 2 allows 1.10 m, order 1 0.56 m
        order = best_order(errors, depths)
        assert (order.name if order else None) == name
    assert pytest.approx(0.95) == CONFIDENCE


def test_no_errors_meet_no_order():
    none = np.empty(0)
    assert best_order(none, none) is None
    assert np.isnan(share_within(ORDERS[0], none, none))
