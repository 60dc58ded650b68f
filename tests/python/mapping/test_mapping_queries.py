"""Queries, changed voxels, merging and the sensor model, in both engines."""

import math

import numpy as np
import pytest

from uwsim.mapping import OccupancyMap, OccupancyModel

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


def as_states(cubes):
    return dict(zip(map(tuple, cubes.centres_m.tolist()), cubes.states.tolist(), strict=True))


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


def test_both_engines_answer_alike():
    first, second = (some_map(engine, seed=3) for engine in ENGINES)
    rng = np.random.default_rng(5)
    origins, directions = MIDDLE + rng.uniform(-5, 5, (500, 3)), rng.normal(size=(500, 3))
    for ignore in (False, True):
        one, two = (m.cast_rays(origins, directions, 15.0, ignore) for m in (first, second))
        np.testing.assert_array_equal(one.states, two.states)
        np.testing.assert_array_equal(one.voxels_m, two.voxels_m)
        assert set(one.states) == ({0, 1} if ignore else {-1, 1})
    for ask in (OccupancyMap.leaves, lambda m: m.cells(12), lambda m: m.voxels_in([5, 15, -9], [12, 22, -1])):
        one, two = ask(first), ask(second)
        assert len(one) > 0
        for name in ("centres_m", "edges_m", "log_odds"):
            np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


@pytest.mark.parametrize("engine", ENGINES)
def test_changes_keep_a_copy_up_to_date(engine):
    occupancy, copy = some_map(engine), {}
    reported = []
    for step in range(6):
        changes = occupancy.changed_voxels()
        reported.append(len(changes))
        for centre, state in zip(map(tuple, changes.centres_m.tolist()), changes.states.tolist(), strict=True):
            assert copy.get(centre) != state
            copy[centre] = state
        assert copy == as_states(everything(occupancy))
        if step == 3:
            occupancy.merge(some_map(engine, seed=9))
        elif step != 1:
            occupancy.insert_scan(MIDDLE + np.random.default_rng(step).uniform(-9, 9, (30, 3)), MIDDLE)
    assert reported[0] > max(reported[1:])
    assert [count > 0 for count in reported] == [True, True, False, True, True, True]


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


@pytest.mark.parametrize("engine", ENGINES)
def test_points_outside_are_counted_on_request(engine):
    points = np.array([[1, 1, 1], [1e5, 0, 0], [2, 1, 1]])
    with pytest.raises(ValueError, match="must be within"):
        OccupancyMap(engine=engine).insert_scan(points, [0, 0, 0])
    occupancy = OccupancyMap(engine=engine, on_outside="count")
    occupancy.insert_scan(points, [0, 0, 0])
    assert occupancy.statistics().outside_points == 1
    occupancy.insert_scans(points[[0, 1, 2, 1]], [1, 3], [[9e4, 0, 0], [0, 0, 0]])
    assert occupancy.statistics().outside_points == 4
    assert occupancy.statistics().occupied_voxels == 2
    with pytest.raises(ValueError, match=r"map\.on_outside = 'lose': must be one of raise, count"):
        OccupancyMap(on_outside="lose")


@pytest.mark.parametrize("engine", ENGINES)
def test_model_acts_on_later_scans_only(engine):
    occupancy = OccupancyMap(EDGE_M, engine=engine, hit=0.8)
    assert occupancy.model == OccupancyModel(hit=0.8)
    point, origin = [[3.1, 0.1, 0.1]], [0.1, 0.1, 0.1]
    occupancy.insert_scan(point, origin)
    occupancy.model = OccupancyModel(hit=0.6, miss=0.3, clamping=(0.2, 0.75))
    assert occupancy.model.clamping == (0.2, 0.75)
    assert occupancy.probability_at(point)[0] == pytest.approx(0.8)  # unchanged
    for _ in range(9):
        occupancy.insert_scan(point, origin)
    assert occupancy.probability_at([[1.1, 0.1, 0.1]])[0] == pytest.approx(0.2)
    with pytest.raises(ValueError, match=r"map\.hit = 0\.2: must be in \[0\.5, 1\)"):
        occupancy.model = OccupancyModel(hit=0.2)
    assert occupancy.model.hit == 0.6
