"""Voxel keys equal OctoMap's; earlier queries of SurfaceVoxels affect only the time a query takes."""

from __future__ import annotations

import numpy as np
import pytest

from uwsim import _core
from uwsim.mapping.voxel_keys import pack_keys, sorted_unique, unpack_keys, voxel_centres_m, voxel_keys

VOXEL_M = 0.25


@pytest.fixture
def rays() -> _core.RayScene:
    x, y = np.meshgrid(np.arange(-10.0, 11.0), np.arange(-10.0, 11.0))
    world = _core.World()
    world.set_terrain((0.3 * x + np.sin(y)).astype(np.float32), 1.0, (-10.0, -10.0))
    return _core.RayScene(world)


def keys_near_the_bed() -> np.ndarray:
    points = np.random.default_rng(3).uniform((-8.0, -8.0, -4.0), (8.0, 8.0, 4.0), (5000, 3))
    return np.unique(pack_keys(voxel_keys(points, VOXEL_M)))


def test_distances_are_those_of_the_centres_whatever_was_looked_at(rays: _core.RayScene):
    keys = keys_near_the_bed()
    centres = voxel_centres_m(unpack_keys(keys), VOXEL_M)
    surface = _core.SurfaceVoxels(rays, VOXEL_M)
    surface.look_at(centres[::3].astype(np.float32))
    surface.look_at(np.array([[np.nan, 0.0, 0.0], [1e30, 0.0, 0.0]], np.float32))  # outside every voxel
    assert len(surface) == len(keys[::3])
    for _ in range(2):
        assert np.array_equal(surface.distances_m(keys), rays.distance_m(centres))
    assert len(surface) == len(keys)


def test_a_voxel_that_holds_a_point_of_the_surface_holds_surface(rays: _core.RayScene):
    keys = keys_near_the_bed()
    surface = _core.SurfaceVoxels(rays, VOXEL_M)
    distances = surface.distances_m(keys)
    hold = surface.hold_surface(keys, distances)
    assert hold[distances <= VOXEL_M / 2.0].all()
    assert not hold[distances > np.sqrt(3.0) * VOXEL_M / 2.0 + 0.001].any()
    down = np.broadcast_to([0.0, 0.0, -1.0], (200, 3))
    above = np.column_stack([np.random.default_rng(4).uniform(-8.0, 8.0, (200, 2)), np.full(200, 20.0)])
    met = above + rays.cast(above, down, 100.0).ranges_m[:, None] * down
    middle = np.abs(met / VOXEL_M - np.floor(met / VOXEL_M) - 0.5).max(axis=1) < 0.4  # bisection may miss corners
    on_it = pack_keys(voxel_keys(met[middle], VOXEL_M))
    assert surface.hold_surface(on_it, surface.distances_m(on_it)).all()


def test_bad_input_is_named(rays: _core.RayScene):
    with pytest.raises(ValueError, match="resolution_m"):
        _core.SurfaceVoxels(rays, 0.0)
    surface = _core.SurfaceVoxels(rays, VOXEL_M)
    with pytest.raises(ValueError, match="voxels"):
        surface.distances_m(np.array([-1]))
    with pytest.raises(ValueError, match="distances_m"):
        surface.hold_surface(keys_near_the_bed(), np.zeros(1))


def test_keys_are_rounded_down_and_packed_in_order_without_collisions():
    assert voxel_keys(np.array([[-0.01, 0.0, 0.5]]), 0.5).tolist() == [[-1, 0, 1]]
    keys = np.array([[i, j, k] for i in (-32768, -1, 0, 32767) for j in (-32768, 0, 7) for k in (-2, 3)])
    assert np.all(np.diff(pack_keys(keys)) > 0)
    assert np.array_equal(unpack_keys(pack_keys(keys)), keys)


def test_sorted_unique_keys_are_those_of_numpy() -> None:
    keys = np.random.default_rng(4).integers(-50, 50, 500)
    np.testing.assert_array_equal(sorted_unique(keys), np.unique(keys))
    assert len(sorted_unique(keys[:0])) == 0
