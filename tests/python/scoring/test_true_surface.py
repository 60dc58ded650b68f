"""Samples of the true surface leave no gaps and are generated in tiles."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from uwsim import _core
from uwsim.mapping.voxel_keys import pack_keys, unpack_keys, voxel_keys
from uwsim.scoring import true_surface
from uwsim.scoring.true_surface import SurfaceSamples, surface_tiles

SQUARE = np.array([[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]])


def sample_surface(world, resolution_m, area_world_m):
    """Return the samples of all surface_tiles combined."""
    tiles = list(surface_tiles(world, resolution_m, area_world_m))
    points = np.concatenate([np.empty((0, 3)), *[tile.points_world_m for tile in tiles]])
    keys = np.concatenate(
        [np.empty(0, np.int64), *[pack_keys(tile.voxel_keys)[tile.voxel_of_sample] for tile in tiles]]
    )
    voxels, voxel_of_sample = np.unique(keys, return_inverse=True)
    order = np.argsort(voxel_of_sample, kind="stable")
    return SurfaceSamples(points[order], voxel_of_sample[order], unpack_keys(voxels))


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
    # Half the diagonal of the sampling grid, plus a full diagonal, since each cell of the grid keeps only one sample.
    assert distances.max() <= 0.25 * (np.sqrt(0.5) + np.sqrt(3.0))
    inside = {tuple(key) for key in samples.voxel_keys}
    assert {tuple(key) for key in voxel_keys(samples.points_world_m, 0.5)} == inside


def test_parts_of_solids_under_the_terrain_are_not_surface():
    world = _core.World()
    world.set_terrain(np.zeros((41, 41), np.float32), 1.0, (-20.0, -20.0))
    alone = len(sample_surface(world, 0.5, SQUARE).points_world_m)
    world.add_solid("buried", np.array([[0.0, 0.0, -3.0], [5.0, 0.0, -3.0], [0.0, 5.0, -2.0]]), np.array([[0, 1, 2]]))
    assert len(sample_surface(world, 0.5, SQUARE).points_world_m) == alone


def vast_floor(half_m=5000.0):
    world = _core.World()
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * half_m
    world.add_solid("floor", np.column_stack([corners, np.full(4, -3.2)]), np.array([[0, 1, 2], [0, 2, 3]]))
    return world


def test_the_parts_of_triangles_outside_the_polygon_cost_nothing():
    samples = sample_surface(vast_floor(half_m=1.0e7), 0.5, SQUARE)  # sampling the whole floor would take 6e15 samples
    assert len(samples.voxel_keys) == 40 * 40 / 0.5**2
    assert np.abs(samples.points_world_m[:, :2]).max() <= 20.0


def test_tiles_share_no_voxel_and_together_are_the_whole(monkeypatch):
    world = _core.World()
    x, y = np.meshgrid(np.arange(-21.0, 22.0), np.arange(-21.0, 22.0))
    world.set_terrain((np.sin(x / 3.0) * 2.0 + y / 7.0 - 9.0).astype(np.float32), 1.0, (-21.0, -21.0))
    world.add_solid("wall", np.array([[-90.0, -70, -30], [90, 80, -30], [3, 2, 40]]), np.array([[0, 1, 2]]))
    whole = sample_surface(world, 0.3, SQUARE)
    monkeypatch.setattr(true_surface, "TILE_VOXELS", 17)
    tiles = list(surface_tiles(world, 0.3, SQUARE))
    assert len(tiles) > 50
    assert np.array_equal(
        np.sort(np.concatenate([pack_keys(tile.voxel_keys) for tile in tiles])), pack_keys(whole.voxel_keys)
    )
    assert np.array_equal(sample_surface(world, 0.3, SQUARE).points_world_m, whole.points_world_m)


def test_a_box_bounds_the_samples():
    within = np.array([-2.0, -9.0, -4.0]), np.array([3.0, 1.0, 0.0])
    points = np.concatenate([tile.points_world_m for tile in surface_tiles(vast_floor(), 0.5, SQUARE, within)])
    assert points[:, :2].min(axis=0) == pytest.approx(within[0][:2], abs=1.0)
    assert points[:, :2].max(axis=0) == pytest.approx(within[1][:2], abs=1.0)
    above = np.array([-2.0, -9.0, -1.0]), np.array([3.0, 1.0, 0.0])
    assert not list(surface_tiles(vast_floor(), 0.5, SQUARE, above))


def test_too_many_voxels_are_refused_before_the_first_tile():
    with pytest.raises(ValueError, match=r"true surface = about 64 million: must be at most 50 million"):
        sample_surface(vast_floor(), 0.005, SQUARE)
    triangle = SQUARE[:3]
    assert next(surface_tiles(vast_floor(), 0.005, triangle)), "half of them are not too many"
