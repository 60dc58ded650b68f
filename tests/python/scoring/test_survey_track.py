"""The track file of a survey, and the vertical uncertainty orders of IHO S-44."""

import numpy as np
import pytest

from uwsim.scoring.s44 import CONFIDENCE, ORDERS, best_order, share_within
from uwsim.scoring.survey_track import SurveyTrack

INTERNALS = ("zip", "zlib", "pickle", "CRC", "EOF", "descr", "header", "reshape", "NumPy", "numpy")


def test_a_track_is_read_as_written_and_a_damaged_one_is_refused(tmp_path):
    path = tmp_path / "track.npz"
    track = SurveyTrack(
        np.random.default_rng(0).normal(size=(50, 3)), np.array([[0.0, 0], [1, 0], [0, 1]]), 54.9, "pool"
    )
    track.write(path)
    back = SurveyTrack.read(path)
    assert np.array_equal(back.path_world_m, track.path_world_m)
    assert np.array_equal(back.area_world_m, track.area_world_m)
    assert (back.range_max_m, back.scenario_name) == (54.9, "pool")
    whole = path.read_bytes()
    track.write(path)
    assert path.read_bytes() == whole
    random = np.random.default_rng(1)
    for trial in range(60):
        data = bytearray(whole)
        if trial % 2:
            del data[random.integers(len(data)) :]
        else:
            data[random.integers(len(data))] ^= 0xFF
        path.write_bytes(bytes(data))
        try:
            SurveyTrack.read(path)
        except ValueError as error:
            assert "not a valid track" in str(error)
            assert not any(word in str(error) for word in INTERNALS), "messages are about the file, not about libraries"
    path.unlink()  # uwsim replaces no file that was changed by others
    for bad in (
        SurveyTrack(np.full((2, 3), np.nan), track.area_world_m, 10.0),
        SurveyTrack(np.zeros((2, 2)), track.area_world_m, 10.0),
        SurveyTrack(np.zeros((2, 3)), track.area_world_m[:2], 10.0),
        SurveyTrack(np.zeros((2, 3)), track.area_world_m, -1.0),
    ):
        bad.write(path)
        with pytest.raises(ValueError, match="not a valid track"):
            SurveyTrack.read(path)


def test_another_kind_of_file_is_refused_in_words_that_a_user_knows(tmp_path):
    path = tmp_path / "track.npz"
    for content in (b"", b"# a cloud, perhaps\n1 2 3\n", b"PK\x03\x04 and no more"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match="it is damaged, or another kind of file"):
            SurveyTrack.read(path)
    path.unlink()
    np.savez(path, version=np.int64(1), path_world_m=np.zeros((2, 3)))
    with pytest.raises(ValueError, match="it has no 'area_world_m'"):
        SurveyTrack.read(path)


def test_orders_allow_the_uncertainties_of_their_table():
    """S-44 edition 6, Table 1, at 0 and 100 m: sqrt(a^2 + (100 b)^2), and the horizontal ones."""
    at = np.array([0.0, 100.0])
    allowed = {order.name: (order.tvu_m(at).tolist(), order.thu_m(at).tolist()) for order in ORDERS}
    assert allowed["Exclusive"] == (pytest.approx([0.15, 0.764853], rel=1e-5), [1.0, 1.0])
    assert allowed["Special"] == (pytest.approx([0.25, 0.790569], rel=1e-5), [2.0, 2.0])
    assert allowed["1a"] == allowed["1b"] == (pytest.approx([0.5, 1.392839], rel=1e-5), [5.0, 10.0])
    assert allowed["2"] == (pytest.approx([1.0, 2.507987], rel=1e-5), [20.0, 30.0])
    assert [order.tvu_m(np.array([-3.0])) for order in ORDERS] == [allowed[order.name][0][0] for order in ORDERS]


@pytest.mark.parametrize("order", ORDERS, ids=lambda order: order.name)
def test_an_order_is_met_up_to_its_limit_and_not_beyond(order):
    for depth_m in (0.0, 30.0, 300.0):
        depths = np.full(100, depth_m)
        limits_m = order.tvu_m(depths) * np.where(np.arange(100) % 2, 1.0, -1.0)
        assert share_within(order, 0.999 * limits_m, depths) == 1.0
        assert share_within(order, 1.001 * limits_m, depths) == 0.0
        assert best_order(0.999 * limits_m, depths).tvu_m(depths[:1]) == order.tvu_m(depths[:1])
        worse = best_order(1.001 * limits_m, depths)
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
