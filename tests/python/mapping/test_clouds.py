"""Cloud filters and fits: known centroids, planes are recovered."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwsim.mapping import clouds

FAR = np.array([4321.0, -1234.0, -87.0])


def some_points(n: int, seed: int = 0, half_m: float = 5.0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-half_m, half_m, (n, 3)).astype(np.float32)


def bumpy_bed(n: int, seed: int = 0) -> np.ndarray:
    """Return points on a bed with slopes in many directions."""
    xy = np.random.default_rng(seed).uniform(-8.0, 8.0, (n, 2))
    z = 1.2 * np.sin(xy[:, 0] / 1.7) + 1.0 * np.cos(xy[:, 1] / 1.3) + 0.3 * np.sin(xy.sum(axis=1))
    return np.column_stack([xy, z])


@given(
    n=st.integers(1, 300), seed=st.integers(0, 1000), voxel_m=st.sampled_from([0.1, 0.5, 1.0, 3.0]), far=st.booleans()
)
def test_the_voxel_grid_gives_the_centroid_of_each_cube(n, seed, voxel_m, far):
    points = (some_points(n, seed) + far * FAR).astype(np.float32)
    wide = points.astype(np.float64)
    edge_m = np.abs(wide / voxel_m - np.round(wide / voxel_m)).min(axis=1) * voxel_m
    points, wide = points[edge_m > 1e-3], wide[edge_m > 1e-3]  # rounding to float32 may move a point across a cell face
    keys, cube, count = np.unique(np.floor(wide / voxel_m), axis=0, return_inverse=True, return_counts=True)
    expected = np.zeros((len(keys), 3))
    np.add.at(expected, cube, wide)
    got = clouds.voxel_grid(points, voxel_m)
    assert got.dtype == np.float32
    assert len(got) == len(keys)
    order = np.lexsort(keys.T)  # z varies slowest, x fastest
    assert np.abs(got - (expected / count[:, None])[order]).max(initial=0.0) < (3e-4 if far else 3e-6)


def test_a_voxel_too_small_for_the_cloud_is_refused():
    with pytest.raises(ValueError, match=r"voxel_m = 1e-05: too small for the cloud's box"):
        clouds.voxel_grid([[0, 0, 0], [100, 100, 100]], 1e-5)
    assert len(clouds.voxel_grid([[1e30, 0, 0]], 0.1)) == 1, "one cube is possible anywhere"


def test_pass_through_keeps_the_slab_including_its_faces():
    points = np.array([[1, 2, 3], [4, 5, 6], [7, 8, 9], [np.nan, 5, 5], [0, math.inf, 0]], np.float32)
    assert clouds.pass_through(points, "y", 2, 5).tolist() == [[1, 2, 3], [4, 5, 6]]
    assert clouds.pass_through(points, "z", min_m=6).tolist() == [[4, 5, 6], [7, 8, 9]]
    assert clouds.pass_through(points, "x", max_m=0.5).tolist() == []


def test_isolated_points_are_outliers_and_the_others_keep_their_order():
    crowd = (some_points(2000, half_m=1.0) + FAR).astype(np.float32)
    isolated = (FAR + np.diag([9.0, -9.0, 9.0])).astype(np.float32)
    kept = clouds.remove_outliers(np.concatenate([isolated, crowd, [[np.nan] * 3]]).astype(np.float32), 8, 3.0)
    assert not (kept[:, None] == isolated).all(axis=2).any()
    at = [int(np.flatnonzero((crowd == p).all(axis=1))[0]) for p in kept[::50]]
    assert at == sorted(at)
    assert len(kept) > 1800


@given(slope_deg=st.floats(0, 28), azimuth=st.floats(0, 6.28), height_m=st.floats(-50, 50), far=st.booleans())
def test_a_plane_in_clutter_is_recovered(slope_deg, azimuth, height_m, far):
    slope = math.radians(slope_deg)
    normal = np.array([math.sin(slope) * math.cos(azimuth), math.sin(slope) * math.sin(azimuth), math.cos(slope)])
    random = np.random.default_rng(1)
    xy = random.uniform(-10, 10, (400, 2))
    z = height_m - xy @ normal[:2] / normal[2]
    on_plane = np.column_stack([xy, z]) + random.uniform(-0.02, 0.02, (400, 3))
    clutter = np.column_stack([random.uniform(-10, 10, (150, 2)), height_m + random.uniform(8, 20, 150)])
    shift = far * FAR
    plane = clouds.ground_plane(np.concatenate([clutter, on_plane]) + shift, distance_m=0.1)
    assert np.linalg.norm(plane.normal) == pytest.approx(1.0)
    assert math.acos(min(1.0, plane.normal @ normal)) < math.radians(0.2)
    assert plane.inliers.dtype == bool
    assert plane.inliers[150:].all()
    assert not plane.inliers[:150].any()
    assert np.abs(plane.height_of(on_plane + shift)).max() < 0.06


def test_a_wall_is_not_ground():
    random = np.random.default_rng(2)
    wall = np.column_stack([np.zeros(500), random.uniform(-5, 5, (500, 2))])
    ground = np.column_stack([random.uniform(-5, 5, (100, 2)), np.full(100, -5.0)])
    plane = clouds.ground_plane(np.concatenate([wall, ground]), distance_m=0.05)
    assert plane.normal == pytest.approx([0, 0, 1], abs=1e-3)
    assert plane.offset_m == pytest.approx(5.0, abs=1e-3)
    with pytest.raises(ValueError, match="three points on a plane"):
        clouds.ground_plane(np.column_stack([np.zeros(50), np.linspace(0, 1, 50), np.zeros(50)]), 0.1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: clouds.voxel_grid(p[:, :2], 1.0), r"points_m.shape = \(20, 2\): expected \(n, 3\)"),
        (lambda p: clouds.voxel_grid(p.astype(complex), 1.0), r"points_m.dtype = complex128"),
        (lambda p: clouds.voxel_grid(p, 0.0), r"voxel_m = 0: must be positive"),
        (lambda p: clouds.voxel_grid(p, math.nan), r"voxel_m = nan"),
        (lambda p: clouds.pass_through(p, "w", 0, 1), r"axis = 'w'"),
        (lambda p: clouds.pass_through(p, "x", 2, 1), r"max_m = 1: must be at least min_m"),
        (lambda p: clouds.pass_through(p, "x", math.nan, 1), r"min_m = nan"),
        (lambda p: clouds.remove_outliers(p, 20), r"neighbours = 20: must be less than the number of points, 20"),
        (lambda p: clouds.remove_outliers(p, 0), r"neighbours = 0"),
        (lambda p: clouds.remove_outliers(p, 5, -1.0), r"deviations = -1"),
        (lambda p: clouds.ground_plane(p[:2], 0.1), r"points_m.size = 2: must be at least 3 points"),
        (lambda p: clouds.ground_plane(np.where(p > 4, np.nan, p), 0.1), r"points_m\[\d+\] = nan: must be finite"),
        (lambda p: clouds.ground_plane(p, 0.1, 0.0), r"max_slope_rad = 0"),
    ],
)
def test_a_mistake_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(some_points(20))


def test_an_empty_cloud_gives_an_empty_cloud():
    empty = np.empty((0, 3), np.float32)
    for got in (clouds.voxel_grid(empty, 1.0), clouds.pass_through(empty, "z"), clouds.remove_outliers(empty)):
        assert got.shape == (0, 3)


def test_the_same_points_give_the_same_bytes():
    points = np.concatenate([some_points(3000), bumpy_bed(2000)]).astype(np.float32)
    first, second = (
        (
            clouds.voxel_grid(points, 0.4).tobytes(),
            clouds.remove_outliers(points, 10, 1.0).tobytes(),
            clouds.ground_plane(points, 0.3).normal.tobytes(),
        )
        for _ in range(2)
    )
    assert first == second


def test_pcl_prints_nothing_on_stderr(capfd):
    line = np.column_stack([np.linspace(0, 1, 9), np.zeros(9), np.zeros(9)])
    with pytest.raises(ValueError, match="points_m"):
        clouds.ground_plane(line, 0.1)
    assert capfd.readouterr().err == ""
