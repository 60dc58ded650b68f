"""The true surface's samples leave no gap, and keys are OctoMap's."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from uwsim import _core
from uwsim.survey.true_surface import inside_polygon, packed, sample_surface, voxel_keys

SQUARE = np.array([[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]])


@pytest.mark.parametrize(
    "corners",
    [
        [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 1.0]],
        [[0.0, 0.0, 0.0], [15.0, 9.0, 4.0], [7.5, 4.52, 2.0]],  # a sliver
        [[-3.0, 1.0, -2.0], [-2.9, 1.1, -2.0], [-3.0, 1.05, -1.9]],  # smaller than a voxel
    ],
)
def test_every_point_of_a_triangle_is_near_a_sample(corners):
    world = _core.World()
    world.add_solid("triangle", np.array(corners), np.array([[0, 1, 2]]))
    samples = sample_surface(world, 0.5, SQUARE)
    weights = np.random.default_rng(1).dirichlet([1.0, 1.0, 1.0], 2000)
    distances, _ = cKDTree(samples.points_world_m).query(weights @ np.array(corners))
    # Half the diagonal of the sampling grid; one more, since only one sample is kept in each cell of it.
    assert distances.max() <= 0.25 * (np.sqrt(0.5) + np.sqrt(3.0))
    inside = {tuple(key) for key in samples.voxel_keys}
    assert {tuple(key) for key in voxel_keys(samples.points_world_m, 0.5)} == inside


def test_what_lies_under_the_terrain_is_no_surface():
    world = _core.World()
    world.set_terrain(np.zeros((41, 41), np.float32), 1.0, (-20.0, -20.0))
    alone = len(sample_surface(world, 0.5, SQUARE).points_world_m)
    world.add_solid("buried", np.array([[0.0, 0.0, -3.0], [5.0, 0.0, -3.0], [0.0, 5.0, -2.0]]), np.array([[0, 1, 2]]))
    assert len(sample_surface(world, 0.5, SQUARE).points_world_m) == alone


def test_keys_are_floors_and_pack_without_collisions_in_order():
    assert voxel_keys(np.array([[-0.01, 0.0, 0.5]]), 0.5).tolist() == [[-1, 0, 1]]
    keys = np.array([[i, j, k] for i in (-32768, -1, 0, 32767) for j in (-32768, 0, 7) for k in (-2, 3)])
    assert np.all(np.diff(packed(keys)) > 0)


def test_a_polygon_and_its_mirror_winding_hold_the_same_points():
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]])  # a notch from above
    points = np.array([[1.0, 1.0], [2.0, 3.0], [3.5, 2.0], [5.0, 1.0], [-1.0, 1.0]])
    assert inside_polygon(points, corners).tolist() == [True, False, True, False, False]
    assert inside_polygon(points, corners[::-1]).tolist() == [True, False, True, False, False]
