"""Distances, collisions, views and frontiers of a map, held against SciPy's exact transforms and closed forms."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from uwsim.mapping import DistanceField, OccupancyMap, body_points, frontiers, poses_along

EDGE_M = 0.25
LOW, HIGH = np.array([-6.0, -5.0, -4.0]), np.array([6.0, 5.0, 4.0])
UPRIGHT = [0.0, 0.0, 0.0, 1.0]
CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-0.5, 0.5) for z in (-0.3, 0.3)])
CUBE_TRIANGLES = ConvexHull(CUBE).simplices


def seen(engine="bricks", scans=6, seed=1):
    """Return a map of random echoes around some places."""
    rng = np.random.default_rng(seed)
    world = OccupancyMap(EDGE_M, (0.3, 0.0, 0.0), engine=engine)
    for _ in range(scans):
        world.insert_scan(rng.uniform(LOW, HIGH, (80, 3)), rng.uniform(-1, 1, 3))
    return world


def truth(world, unknown_is_occupied=False, low=LOW, high=HIGH):
    """Return SciPy's exact distances of a box of voxels."""
    states = world.states_in(low, high).states
    blocked = (states == 1) | ((states < 0) & unknown_is_occupied)
    return EDGE_M * ndimage.distance_transform_edt(~blocked)


@pytest.mark.parametrize("engine", ["octomap", "bricks"])
def test_grid_of_states_is_the_map(engine):
    world = seen(engine)
    grid = world.states_in(LOW, HIGH)
    places = grid.low_centre_world_m + EDGE_M * np.argwhere(np.ones(grid.states.shape))
    np.testing.assert_array_equal(grid.states.ravel(), world.state_at(places))
    assert (places >= LOW).all() and (places <= HIGH).all()
    assert (grid.low_centre_world_m - EDGE_M < LOW).all() and (places[-1] + EDGE_M > HIGH).all()
    assert world.states_in([9, 9, 9], [9.01, 9.01, 9.01]).states.size == 0


@pytest.mark.parametrize("unknown", [False, True])
def test_distances_are_scipys_exact_ones_up_to_a_fraction_of_a_voxel(unknown):
    world = seen()
    field = DistanceField(world, LOW, HIGH, max_distance_m=3.0, unknown_is_occupied=unknown)
    expected = np.minimum(truth(world, unknown), 3.0)
    excess = field.grid() - expected
    assert excess.min() > -1e-6
    assert excess.max() < 0.35 * EDGE_M and np.mean(excess > 1e-6) < 0.01, (excess.max(), np.mean(excess > 1e-6))


def test_a_field_that_grew_with_its_map_is_that_of_the_whole_map():
    rng = np.random.default_rng(3)
    world = seen()
    field = DistanceField(world, LOW, HIGH, max_distance_m=4.0)
    assert field.update() == 0
    for _ in range(20):  # echoes appear, and disappear again as rays pass
        before = world.states_in(LOW, HIGH).states == 1
        world.insert_scan(rng.uniform(LOW, HIGH, (40, 3)), rng.uniform(-2, 2, 3))
        assert field.update() == np.sum(before != (world.states_in(LOW, HIGH).states == 1))
    excess = field.grid() - np.minimum(truth(world), 4.0)
    assert excess.min() > -1e-6
    assert excess.max() < 0.35 * EDGE_M and np.mean(excess > 1e-6) < 0.01


def test_a_wall_gives_a_plane_of_distances_and_its_normal():
    world = OccupancyMap(EDGE_M)
    y, z = np.meshgrid(np.arange(-4.9, 5, EDGE_M), np.arange(-4.9, 5, EDGE_M))
    world.insert_scan(np.column_stack([np.full(y.size, 3.1), y.ravel(), z.ravel()]), [0, 0, 0])
    field = DistanceField(world, [-3, -2, -2], [4, 2, 2], max_distance_m=5.0)
    points = np.random.default_rng(1).uniform([-1.5, -1.5, -1.5], [2.5, 1.5, 1.5], (200, 3))
    np.testing.assert_allclose(field.distance_m(points), 3.125 - points[:, 0], atol=1e-6)
    np.testing.assert_allclose(field.gradient(points), [[-1, 0, 0]] * 200, atol=1e-6)
    assert np.isnan(field.distance_m([[9, 0, 0]])) and np.isnan(field.gradient([[9, 0, 0]])).all()


def test_a_sphere_is_blocked_by_the_voxels_it_touches():
    world = seen()
    centres = np.random.default_rng(2).uniform(LOW - 1, HIGH + 1, (40, 3))
    box = world.states_in([-9, -9, -9], [9, 9, 9])
    for unknown_blocks in (False, True):
        blocking = (box.states == 1) | ((box.states < 0) & unknown_blocks)
        low = box.low_centre_world_m + EDGE_M * np.argwhere(blocking) - 0.5 * EDGE_M
        gaps = [np.linalg.norm(np.maximum(0, np.maximum(low - c, c - low - EDGE_M)), axis=1).min() for c in centres]
        found = world.spheres_blocked(centres, 0.6, unknown_blocks=unknown_blocks)
        np.testing.assert_array_equal(found, np.array(gaps) <= 0.6)
        assert 0 < found.sum() <= 40


def test_a_hull_is_blocked_by_what_lies_inside_it_and_free_beside_it():
    points = body_points(CUBE, CUBE_TRIANGLES, 0.1)
    assert np.all(np.abs(points) <= np.array([1.0, 0.5, 0.3]) + 1e-12)
    places = np.random.default_rng(1).uniform([-1, -0.5, -0.3], [1, 0.5, 0.3], (500, 3))
    assert np.linalg.norm(places[:, None] - points, axis=2).min(axis=1).max() < 0.1  # fills the hull
    world = OccupancyMap(EDGE_M)
    for _ in range(3):
        world.insert_scan([[4.1, 0.1, 0.1]], [0, 0.1, 0.1])
    poses = np.array([[4.1, 0.1, 0.1], [2.8, 0.1, 0.1], [4.1, 1.0, 0.1], [4.1, 1.0, 0.1]])
    turns = np.array([UPRIGHT, UPRIGHT, UPRIGHT, Rotation.from_euler("z", 90, degrees=True).as_quat()])
    blocked = world.bodies_blocked(points, poses, turns, unknown_blocks=False)
    assert blocked.tolist() == [True, False, False, True]
    assert world.bodies_blocked(points, poses[1:2], turns[1:2]).tolist() == [True]  # unknown water


def test_no_point_of_a_body_moves_farther_than_a_step_along_a_path():
    turns = Rotation.from_euler("z", [[0], [170], [-100]], degrees=True).as_quat()
    places = [[0, 0, 0], [3, 0, 0], [3, 0, 0]]
    positions, orientations = poses_along(places, turns, 1.2, 0.1)
    np.testing.assert_allclose(positions[[0, -1]], [places[0], places[-1]])
    points = Rotation.from_quat(orientations).apply([0.0, 1.2, 0.0]) + positions
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= 0.1 + 1e-9


def test_a_view_into_the_unknown_is_a_pyramid_up_to_the_wall():
    world = OccupancyMap(EDGE_M)
    y, z = np.meshgrid(np.arange(-9.9, 10, EDGE_M), np.arange(-9.9, 10, EDGE_M))
    wall = np.column_stack([np.full(y.size, 6.1), y.ravel(), z.ravel()])
    for _ in range(2):
        world.insert_scan(wall, [6.3, 0, 0])  # from behind: the water before it stays unknown
    pose, level = [[0.1, 0.1, 0.1]], [UPRIGHT]
    volume_m3 = world.unknown_in_view_m3(pose, level, 60.0, 40.0, 12.0)[0]
    box = world.states_in([-1, -9, -9], [9, 9, 9])
    away_m = box.low_centre_world_m + EDGE_M * np.argwhere(box.states == -1) - pose[0]
    away_m = away_m[away_m[:, 0] < 6.0]
    sides = np.abs(away_m[:, 1:]) - away_m[:, :1] * np.tan(np.radians([30, 20]))  # of voxels' centres to the faces
    inside = (sides <= 0).all(axis=1).sum()
    touched = (sides <= EDGE_M / np.cos(np.radians([30, 20]))).all(axis=1).sum()
    assert 0.98 * inside <= volume_m3 / EDGE_M**3 <= touched
    away = world.unknown_in_view_m3(pose, [[0, 0, 1, 0]], 60.0, 40.0, 5.0)[0]
    assert away > 0
    for _ in range(2):
        world.insert_scan(wall, pose[0])
    assert world.unknown_in_view_m3(pose, level, 20.0, 20.0, 12.0)[0] < 0.02 * volume_m3  # now it is known


def test_frontiers_are_the_free_voxels_beside_unknown_ones_in_clusters():
    world = OccupancyMap(EDGE_M)
    for x in (-3.0, 3.0):  # two separate balls of free water
        ways = Rotation.random(3000, random_state=1).apply([2.0, 0, 0])
        world.insert_scan(ways + np.array([x, 0, 0]), [x, 0, 0], max_range_m=1.5)
    found = frontiers(world, LOW, HIGH)
    assert len(found) == 2
    centres = sorted(frontier.centre_world_m[0] for frontier in found)
    np.testing.assert_allclose(centres, [-3.0, 3.0], atol=0.15)
    for frontier in found:
        assert (world.state_at(frontier.voxels_world_m) == 0).all()
        sides = frontier.voxels_world_m[:, None] + EDGE_M * np.concatenate([np.eye(3), -np.eye(3)])
        assert (world.state_at(sides.reshape(-1, 3)).reshape(-1, 6) == -1).any(axis=1).all()
    assert frontiers(world, LOW, HIGH, voxels_min=10**6) == []


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda world: DistanceField(world, LOW, HIGH, max_distance_m=0.1), "max_distance_m = 0.1: must be from one"),
        (lambda world: DistanceField(world, HIGH, LOW), "the low corner must not be above"),
        (lambda world: DistanceField(world, [-1e3] * 3, [1e3] * 3), "must be at most 32000000"),
        (lambda world: DistanceField(world, [9, 9, 9], [9.01, 9.01, 9.01]), "contains no voxel"),
        (lambda world: world.spheres_blocked([[0, 0, 0]], -1.0), "radius_m = -1: must be from 0"),
        (lambda world: world.spheres_blocked([[np.nan, 0, 0]], 1.0), "centres_world_m = nan: must be finite"),
        (lambda world: world.bodies_blocked([[0, 0, 0]], [[0, 0, 0]], [[0, 0, 0, 2]]), "must be of length 1"),
        (lambda world: world.unknown_in_view_m3([[0, 0, 0]], [UPRIGHT], 180, 40, 5), "field_of_view = 3.14159"),
        (lambda world: world.unknown_in_view_m3([[0, 0, 0]], [UPRIGHT], 90, 40, 500), "range_m = 500: must be from 1"),
        (lambda world: frontiers(world, LOW, HIGH, voxels_min=0), "voxels_min = 0: must be at least 1"),
        (lambda world: body_points(CUBE, CUBE_TRIANGLES, 0.0), "spacing_m = 0.0 m: must be positive"),
        (lambda world: poses_along([[0, 0, 0]], [UPRIGHT], 1, 0.1), "must be"),
    ],
)
def test_bad_arguments_are_refused(call, text):
    with pytest.raises(ValueError, match=text.replace("(", r"\(")):
        call(seen(scans=1))
