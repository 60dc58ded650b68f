"""Queries, changed voxels, merging and the sensor model, in both engines."""

import math

import numpy as np
import pytest

from uwsim.mapping import OccupancyMap

ENGINES = ["octomap", "bricks"]
EDGE_M = 0.5
MIDDLE = np.array([10.0, 20.0, -5.0])


def some_map(engine, seed=1, origin=(10.0, 20.0, -5.0), scans=4, **options):
    rng = np.random.default_rng(seed)
    occupancy = OccupancyMap(EDGE_M, origin, engine=engine, **options)
    for scan in range(scans):
        points = MIDDLE + rng.uniform(-8, 8, (60, 3))
        for _ in range(1 + scan):
            occupancy.insert_scan(points, [10.1 + 0.3 * scan, 20.2, -5.0])
    return occupancy


def everything(occupancy):
    return occupancy.voxels_in([-1e4, -1e4, -1e4], [1e4, 1e4, 1e4])


@pytest.mark.parametrize("engine", ENGINES)
def test_box_of_everything_is_the_map(engine):
    occupancy = some_map(engine)
    cubes = everything(occupancy)
    statistics = occupancy.statistics()
    assert occupancy.count() == (statistics.occupied_voxels, statistics.free_voxels)
    assert len(cubes) == statistics.occupied_voxels + statistics.free_voxels
    np.testing.assert_array_equal(cubes.only(cubes.states == 1).centres_m, occupancy.occupied_voxels())
    np.testing.assert_array_equal(cubes.only(cubes.states == 0).centres_m, occupancy.free_voxels())
    np.testing.assert_array_equal(occupancy.state_at(cubes.centres_m), cubes.states)
    np.testing.assert_array_equal(occupancy.log_odds_at(cubes.centres_m), cubes.log_odds)
    np.testing.assert_array_equal(occupancy.probability_at(cubes.centres_m), cubes.probabilities)
    assert set(cubes.edges_m) == set(occupancy.cells(16).edges_m) == {EDGE_M}
    assert set(occupancy.cells(14).edges_m) == {4 * EDGE_M}
    assert len(occupancy.voxels_in([500, 0, 0], [600, 1, 1])) == 0
    assert np.isnan(occupancy.probability_at([[500, 0, 0], [1e9, 0, 0]])).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_one_point_gives_its_voxel_octomaps_probability_of_a_hit(engine):
    occupancy = OccupancyMap(EDGE_M, engine=engine)
    occupancy.insert_scan([[3.1, 0.1, 0.1]], [0.1, 0.1, 0.1])
    assert occupancy.probability_at([[3.1, 0.1, 0.1]])[0] == pytest.approx(0.7, abs=1e-6)
    assert occupancy.probability_at([[1.1, 0.1, 0.1]])[0] == pytest.approx(0.4, abs=1e-6)
    assert occupancy.log_odds_at([[3.1, 0.1, 0.1]])[0] == np.float32(math.log(0.7 / 0.3))


@pytest.mark.parametrize("engine", ENGINES)
def test_rays_find_a_wall(engine):
    occupancy = OccupancyMap(EDGE_M, engine=engine)
    wall = [[5.1, y, z] for y in np.arange(-2, 2, 0.2) for z in np.arange(-2, 2, 0.2)]
    occupancy.insert_scan(wall, [0.1, 0.1, 0.1])
    origins = np.full((5, 3), 0.1)
    directions = [[2, 0, 0], [1, 0.1, 0], [-1, 0, 0], [1, 0, 0], [0, 0, 1]]
    cast = occupancy.cast_rays(origins[:3], directions[:3], max_range_m=20)
    assert cast.states.tolist() == [1, 1, -1]
    assert cast.voxels_m[0].tolist() == [5.25, 0.25, 0.25]
    assert cast.voxels_m[2].tolist() == [-0.25, 0.25, 0.25]
    assert occupancy.cast_rays(origins[:1], directions[:1], max_range_m=3).states.tolist() == [0]
    assert occupancy.cast_rays(origins[4:], directions[4:], ignore_unknown=True).states.tolist() == [0]
    for length in (1e-300, 1e-40, 1e-20, 1e20, 1e25, 1e300):  # whose squares under- or overflow a float32
        scaled = occupancy.cast_rays(origins[:3], length * np.array(directions[:3]), max_range_m=20)
        np.testing.assert_array_equal(scaled.states, cast.states)
        np.testing.assert_array_equal(scaled.voxels_m, cast.voxels_m)
    with pytest.raises(ValueError, match=r"rays\.directions_world"):
        occupancy.cast_rays([[0, 0, 0]], [[0, 0, 0]])
    with pytest.raises(ValueError, match=r"rays\.origins_world_m"):
        occupancy.cast_rays([[1e6, 0, 0]], [[0, 0, 1]])


def test_maps_on_another_grid_are_not_merged():
    occupancy, far = some_map("bricks", origin=(0, 0, 0)), OccupancyMap(EDGE_M, [-16000, 0, 0])
    far.insert_scan([[-17000, 0, 0]], [-17010, 0, 0])
    before = occupancy.to_bytes("ot")
    for other, rule in (
        (OccupancyMap(0.25), r"merge\.resolution_m = 0\.25: must be that of this map"),
        (OccupancyMap(EDGE_M, [0.2, 0, 0]), r"merge\.origin_world_m = .*a whole number of voxels"),
        (far, "outside this map's cube"),
        (occupancy, "cannot be merged with itself"),
    ):
        with pytest.raises(ValueError, match=rule):
            occupancy.merge(other)
    with pytest.raises(TypeError, match="other = None: must be an OccupancyMap"):
        occupancy.merge(None)
    assert occupancy.to_bytes("ot") == before
