"""Visibility: a group of points is visible if any of its points is visible from any viewpoint."""

import numpy as np
import pytest

from uwsim import _core

TOLERANCE_M, RANGE_M = 0.01, 30.0


@pytest.fixture(scope="module")
def world() -> _core.World:
    """Hills, a half-buried pipe partly filled by the bed, and a wall."""
    x, y = np.meshgrid(np.arange(61), np.arange(61))
    world = _core.World()
    world.set_terrain((1.5 * np.sin(x / 4) * np.cos(y / 5)).astype(np.float32), 1.0, (-30.0, -30.0))
    axis = np.array([[-20.0, 0.0, 1.0], [0.0, 1.0, 0.5], [20.0, 0.0, 1.0]])
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float) * 40.0 - 80.0  # of the pipe's mesh: far off
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.uint32)
    world.add_solid(
        "pipe", np.concatenate([corners, [[-20.0, -2, -2], [20, 3, 3]]]), faces, _core.RoundShape.pipe(axis, 1.2)
    )
    return world


@pytest.fixture(scope="module")
def scene(world: _core.World) -> _core.RayScene:
    return _core.RayScene(world)


def groups_of_points(world: _core.World, scene: _core.RayScene) -> tuple[np.ndarray, np.ndarray]:
    """Return points in groups of four: on surfaces visible from above, on the bed (also in the pipe), and below it."""
    over = np.column_stack([np.random.default_rng(1).uniform(-25, 25, (2000, 2)), np.full(2000, 9.0)])
    over = over[np.lexsort(over.T)]
    bed = np.column_stack([over[:, :2], world.height_at(over[:, :2])])
    met = over - np.outer(scene.cast(over, np.tile([0.0, 0.0, -1.0], (2000, 1)), 50.0).ranges_m, [0, 0, 1])
    group = np.arange(2000) // 4
    return np.select([group[:, None] % 3 == 0, group[:, None] % 3 == 1], [met, bed], bed - [0, 0, 0.2]), group


def test_a_group_is_seen_when_one_of_its_points_is_by_itself(world: _core.World, scene: _core.RayScene) -> None:
    points, group_of = groups_of_points(world, scene)
    viewpoints = np.column_stack([np.linspace(-28, 28, 90), 6 * np.sin(np.arange(90)), 4 + np.cos(np.arange(90))])
    expected = np.zeros(500, bool)
    for viewpoint in viewpoints:
        near = np.linalg.norm(points - viewpoint, axis=1) <= RANGE_M
        seen = scene.visible(viewpoint, points, TOLERANCE_M) & near
        expected[group_of[seen]] = True
    assert 0.2 < expected.mean() < 0.98, "both kinds occur"
    found = scene.seen_groups(viewpoints, points, group_of, 500, RANGE_M, TOLERANCE_M)
    np.testing.assert_array_equal(found, expected)


def test_a_viewpoint_within_a_pipe_sees_its_inside_and_others_do_not(scene: _core.RayScene) -> None:
    inside = np.array([[-10.0, 0.5, 0.9]])
    far_down_the_pipe = np.array([[-14.0, 0.3, 0.9]])
    assert scene.seen_groups(far_down_the_pipe, inside, [0], 1, RANGE_M).all()
    assert not scene.seen_groups([[-10.0, 0.5, 9.0]], inside, [0], 1, RANGE_M).any()


def test_nothing_is_seen_from_nowhere_empty_groups_are_not_seen_and_others_are_refused(scene: _core.RayScene) -> None:
    assert not scene.seen_groups(np.empty((0, 3)), [[0.0, 0, 20]], [0], 1, RANGE_M).any()
    found = scene.seen_groups([[0.0, 0, 10]], [[0.0, 0, 20]], [1], 3, RANGE_M)
    np.testing.assert_array_equal(found, [False, True, False])
    for group_of, rule in (([1, 0], "must be sorted"), ([0, 2], "below group_count"), ([0], "number of points")):
        with pytest.raises(ValueError, match=rule):
            scene.seen_groups([[0.0, 0, 10]], [[0.0, 0, 20], [0, 0, 21]], group_of, 2, RANGE_M)


def test_a_pictures_rays_meet_what_exact_ones_meet(scene: _core.RayScene) -> None:
    rng = np.random.default_rng(2)
    origins = np.column_stack([rng.uniform(-25, 25, (3000, 2)), np.full(3000, 12.0)])
    directions = rng.normal(0.0, 0.3, (3000, 3)) - [0.0, 0.0, 1.0]
    exact, fast = scene.cast(origins, directions, 60.0), scene.cast(origins, directions, 60.0, exact=False)
    same = (exact.labels == fast.labels) & (np.isfinite(exact.ranges_m) == np.isfinite(fast.ranges_m))
    assert same.mean() > 0.999, "all but silhouettes"
    met = same & np.isfinite(exact.ranges_m)
    close = np.abs(exact.ranges_m[met] - fast.ranges_m[met]) < 1e-3
    assert close.mean() > 0.999
    turned = np.einsum("ij,ij->i", exact.normals_world[met], fast.normals_world[met])
    assert np.median(turned) == pytest.approx(1.0, abs=1e-6)


def test_a_distance_does_not_depend_on_the_points_before_it(scene: _core.RayScene) -> None:
    points = np.random.default_rng(3).uniform([-40, -40, -5], [40, 40, 15], (400, 3))
    alone = np.array([scene.distance_m(point[None])[0] for point in points])
    np.testing.assert_array_equal(scene.distance_m(points), alone)
