"""Area coverage planners: lanes over arbitrary polygons, and frontiers of the growing map."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from matplotlib.path import Path as Polygon

import uwsim
from uwsim import Simulator
from uwsim.flight.coverage import SeenBed
from uwsim.mapping import OccupancyMap
from uwsim.missions import lawn_mower_lanes
from uwsim.missions.planners.area_chart import BEYOND_M, AreaChart
from uwsim.missions.planners.boustrophedon import boustrophedon_lanes, mow_area
from uwsim.missions.planners.frontier import explore

CELL = [[-20, -20], [12, -20], [12, -6], [-6, -6], [-6, 14], [-20, 14]]
COMB = [[0, 0], [40, 0], [40, 30], [30, 30], [30, 8], [22, 8], [22, 30], [12, 30], [12, 8], [6, 8], [6, 30], [0, 30]]
TRIANGLE = [[0, 0], [31, 4], [9, 27]]


@pytest.mark.parametrize("area", [CELL, COMB, COMB[::-1]])
@pytest.mark.parametrize("spacing_m", [1.7, 4.0])
def test_lanes_lie_in_the_polygon_and_every_point_of_it_is_within_half_a_spacing_of_one(area, spacing_m) -> None:
    lanes = boustrophedon_lanes(area, spacing_m, np.zeros(2))
    polygon = Polygon(np.array(area, float))
    for lane in lanes:
        inner = lane.start_m + np.linspace(0.01, 0.99, 50)[:, None] * (lane.end_m - lane.start_m)
        assert polygon.contains_points(inner).all()
    for lane in lawn_mower_lanes(area, spacing_m, 1.0, np.zeros(2)):
        inner = lane.start_m + np.linspace(1.01, lane.length_m - 1.01, 50)[:, None] * lane.direction
        assert polygon.contains_points(inner).all(), "apart from its run-outs"
    grid = np.mgrid[-25:45:0.9, -25:45:0.9].reshape(2, -1).T
    for point in grid[polygon.contains_points(grid)]:
        places = [lane.locate(point) for lane in lanes]
        off = [
            max(abs(across), along - lane.length_m, -along) for (along, across), lane in zip(places, lanes, strict=True)
        ]
        assert min(off) <= 0.5 * spacing_m + 1e-6


def test_neighbouring_lanes_of_a_cell_run_back_and_forth_and_cells_are_few() -> None:
    lanes = boustrophedon_lanes(COMB, 2.0, np.zeros(2))
    turns_m = [np.linalg.norm(b.start_m - a.end_m) for a, b in pairwise(lanes)]
    assert sum(turn_m > 2.5 for turn_m in turns_m) <= 3, "four cells or fewer"


def test_lanes_are_across_the_narrowest_way_so_that_they_are_few() -> None:
    lanes = boustrophedon_lanes(TRIANGLE, 2.0, np.zeros(2))
    corners = np.array(TRIANGLE, float)
    heights_m = []
    for k in range(3):
        side = corners[k] - corners[k - 1]
        heights_m.append(abs(np.linalg.det([side, corners[(k + 1) % 3] - corners[k]])) / np.linalg.norm(side))
    assert len(lanes) == np.ceil(min(heights_m) / 2.0)


@pytest.mark.parametrize(
    ("area", "match"),
    [
        ([[0, 0], [1, 1]], "k at least 3"),
        ([[0, 0], [1, 1], [2, 2]], "has no area"),
        ([[0, 0, 1]] * 3, "corners"),
        ([[0, 0], [4, 4], [4, 0], [0, 4]], "must not cross"),
    ],
)
def test_what_is_no_polygon_is_refused(area, match) -> None:
    with pytest.raises(ValueError, match=match):
        boustrophedon_lanes(area, 1.0, np.zeros(2))


SHORE = [[-34, -36], [6, -36], [6, -8], [-34, -8]]
ROUND_THE_ISLAND = [[-14, -14], [24, -14], [24, 20], [-14, 20]]


@pytest.mark.parametrize("area", [SHORE, ROUND_THE_ISLAND], ids=["shore", "island"])
def test_an_area_with_a_shore_or_an_island_in_it_is_seen_whole_and_never_left(area) -> None:
    sim = Simulator("cove", seed=5)
    sim.journal.attach(seen := SeenBed(sim, sim.vehicles))

    def mission(vehicle):
        vehicle.undock()
        return (yield from mow_area(vehicle, area, altitude_m=3.0))

    flown = uwsim.fly(mission, sim)
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    assert flown.simulated_s < 600.0, "it does not grind along the shore"
    if area is ROUND_THE_ISLAND:
        altitude_m = flown.samples["rov"]["altitude_m"][100:]
        assert np.quantile(altitude_m, 0.05) > 2.3, "it follows the bed, and is higher where the bed rises ahead"
        assert np.median(altitude_m) < 4.0 and flown.result.left_out == ()
    polygon, path = shapely.Polygon(area), flown.samples["rov"].path_world_m[:, :2]
    came_in = int(np.argmax(shapely.contains_xy(polygon, path)))
    assert shapely.distance(polygon, shapely.points(path[came_in:])).max() < BEYOND_M + 1.0, "the vehicle swings out"
    grid = np.mgrid[-39.5:40.0, -39.5:40.0].reshape(2, -1).T
    wet = grid[shapely.contains_xy(polygon.buffer(-1.0), grid) & (sim.world.height_at(grid) < -4.5)]
    wet = wet[np.linalg.norm(wet - (8.0, 8.0), axis=1) > 4.0]  # outside the island
    wet = wet[(wet[:, 0] > 1.0) | (np.abs(wet[:, 1] - 18.0) > 2.0)]  # outside the quay
    unseen = [tuple(c) for c in np.floor(wet).astype(int).tolist() if tuple(c) not in seen.cells]
    assert len(unseen) < 0.05 * len(wet), unseen


def test_what_a_map_shows_to_be_too_high_is_left_out_before_the_flight() -> None:
    known = OccupancyMap(resolution_m=0.5)
    shoal = np.mgrid[8:16:0.5, -20:0:0.5].reshape(2, -1).T + 0.25
    for z_m in (-2.0, -2.5):
        ends = np.column_stack([shoal, np.full(len(shoal), z_m)])
        known.insert_scan(ends.astype(np.float32), (12.0, -10.0, -0.25))
    chart = AreaChart([[-10, -20], [20, -20], [20, 0], [-10, 0]], -3.0, np.array([-5.0, -10.0]))
    assert chart.open_at(np.array([[12.0, -10.0]]))[0]
    chart.add_map(known)
    assert chart.open_at(np.array([[12.0, -10.0], [5.5, -10.0], [4.0, -10.0]])).tolist() == [False, False, True]
    assert chart.ways_from(np.array([-5.0, -10.0])).to(np.array([18.9, -10.0])) is None, "it reaches from side to side"


def test_exploring_ends_when_the_map_knows_all_that_can_be_reached() -> None:
    bound_m, cell_m = 13.0, 2.0

    def mission(vehicle):
        vehicle.undock()
        return (yield from explore(vehicle, bound_m, altitude_m=3.0, cell_m=cell_m))

    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    explored = flown.result
    sim = Simulator("cove")
    start = np.array([-13.0, -14.0])
    grid = start + np.mgrid[-30:31:cell_m, -30:31:cell_m].reshape(2, -1).T
    grid = grid[np.linalg.norm(grid - start, axis=1) < bound_m - 1.0]
    open_water = grid[sim.world.height_at(grid) < -5.0]
    voxels = explored.map.occupied_voxels()[:, :2]
    known = [(np.abs(voxels - point).max(axis=1) <= 0.5 * cell_m).any() for point in open_water]
    assert np.mean(known) > 0.97, f"{len(known) - sum(known)} of {len(known)} columns are unknown"
    assert len(explored.given_up) <= 4
