"""Strokes on a bed: their shape is stated, they touch nothing else, and smoothing levels."""

from __future__ import annotations

import numpy as np
import pytest

from uwsim.scenario import Scenario, ScenarioError, Terrain, build_terrain, load
from uwsim.scenario.read.validated import validated
from uwsim.scenario.terrains.noise import NoiseTerrain

FLAT = {"source": "noise", "size_m": [40, 30], "spacing_m": 0.5, "bed_depth_m": 10}


def bed(*strokes: dict[str, object], **more: object) -> Terrain:
    return build_terrain(validated(NoiseTerrain, {**FLAT, **more, "strokes": strokes}))


def test_a_point_is_a_hill_and_a_line_a_ridge_that_end_at_half_their_width() -> None:
    hill = bed({"line_m": [[3, -2]], "width_m": 8, "height_m": 2})
    away = [[3, -2], [5, -2], [3, 0], [7, -2], [3, 2.5], [-15, 9]]
    assert hill.height_at(away) + 10 == pytest.approx([2, 1, 1, 0, 0, 0], abs=1e-5)
    trench = bed({"line_m": [[-8, 0], [0, 0], [0, 8]], "width_m": 4, "height_m": -3})
    at = [[-8, 0], [-4, 0], [0, 0], [0, 5], [-4, 1], [1, 5], [-10, 0], [-4, 2.5], [3, 3]]
    assert trench.height_at(at) + 10 == pytest.approx([-3, -3, -3, -3, -1.5, -1.5, 0, 0, 0], abs=1e-5)


def test_strokes_add_one_after_another_and_beyond_the_edge_nothing_is_drawn() -> None:
    one = {"line_m": [[0, 0]], "width_m": 10, "height_m": 1}
    np.testing.assert_allclose(bed(one, one).heights_m + 10, 2 * (bed(one).heights_m + 10), atol=1e-5)
    np.testing.assert_array_equal(bed({**one, "line_m": [[500, 0], [600, 90]]}).heights_m, bed().heights_m)
    assert bed({**one, "line_m": [[20, 15]]}).heights_m[-1, -1] == pytest.approx(-9)  # a corner's hill is cut


def test_smoothing_levels_a_rough_bed_where_it_is_drawn_and_leaves_a_slope() -> None:
    rough = {"hill_height_m": 2, "hill_wavelength_m": 4, "seed": 3}
    before = bed(**rough).heights_m
    after = bed({"line_m": [[-12, 0], [12, 0]], "width_m": 10, "smooth": 1}, **rough).heights_m
    y, x = np.ogrid[-15:15.1:0.5, -20:20.1:0.5]
    inside, outside = (abs(y) < 1) & (abs(x) < 10), (abs(y) > 5) & (x == x)
    assert np.std(after[inside]) < 0.4 * np.std(before[inside])
    np.testing.assert_array_equal(after[outside], before[outside])
    ridge = {"line_m": [[0, -60], [0, 60]], "width_m": 100, "height_m": 20}  # its flank is nearly even
    smoothed = bed(ridge, {"line_m": [[10, 0]], "width_m": 4, "smooth": 1}).heights_m
    assert np.abs(smoothed - bed(ridge).heights_m).max() < 0.02  # 0.046 / m of curvature over 5 nodes: 0.0115


def test_strokes_belong_to_every_source_and_to_the_world_of_a_scenario() -> None:
    pool = load("pool")
    stroke = {"line_m": [[0, 0]], "width_m": 6, "height_m": 1}
    found = validated(Scenario, {**pool.given(), "terrain": {**pool.terrain.given(), "strokes": [stroke]}})
    rise = build_terrain(found.terrain).heights_m - build_terrain(pool.terrain).heights_m
    assert rise.max() == pytest.approx(1) and rise.min() == 0


@pytest.mark.parametrize(
    ("stroke", "message"),
    [
        ({"line_m": [], "width_m": 1}, r"strokes\[0\]\.line_m"),
        ({"line_m": [[0, 0]], "width_m": 0}, r"strokes\[0\]\.width_m = 0.* m: must be"),
        ({"line_m": [[0, 0]], "width_m": 1, "smooth": 2}, r"smooth = 2.*: must be"),
        ({"line_m": [[0, 0], [9, 9]] * 100, "width_m": 10_000}, r"strokes\[0\]\.width_m = 10000 m: those up to"),
    ],
)
def test_a_wrong_stroke_is_refused_in_a_line(stroke: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        bed(stroke)
