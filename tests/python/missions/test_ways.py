"""Ways over grids and through maps: cheapest, around what is occupied or unknown, with clearance, and straightened."""

import math
from collections import deque
from itertools import pairwise

import numpy as np
import pytest

import uwsim
from uwsim.mapping import OccupancyMap
from uwsim.missions import StoppedError
from uwsim.missions.grid_ways import Grid, GridWays, straightened
from uwsim.missions.planners.cells import NEIGHBOURS, Cell, nearest
from uwsim.missions.planners.map_way import FreeWater, go_by_map


def step_cost(cost: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(a - b) * 0.5 * (cost[tuple(a)] + cost[tuple(b)]))


@pytest.mark.parametrize("shape", [(9, 7), (5, 4, 6)])
@pytest.mark.parametrize("diagonal", [True, False])
def test_no_step_makes_a_way_cheaper_and_every_way_costs_what_it_is_said_to(shape, diagonal) -> None:
    random = np.random.default_rng(3)
    for _ in range(10):
        cost = np.where(random.random(shape) < 0.3, np.inf, random.uniform(0.5, 5.0, shape))
        source = np.array([size // 2 for size in shape])
        cost[tuple(source)] = 1.0
        ways = GridWays(cost, source[None], diagonal=diagonal)
        cells = np.argwhere(np.isfinite(cost))
        for cell in cells:
            off = np.abs(cells - cell)
            neighbours = cells[(off.max(axis=1) == 1) if diagonal else (off.sum(axis=1) == 1)]
            costs = [ways.costs[tuple(other)] + step_cost(cost, other, cell) for other in neighbours]
            best = 0.0 if (cell == source).all() else min(costs, default=math.inf)
            assert ways.costs[tuple(cell)] == pytest.approx(best)
            way = ways.to(cell)
            assert (way is None) == (best == math.inf)
            if way is not None:
                assert (way[0] == source).all() and (way[-1] == cell).all()
                assert sum(step_cost(cost, a, b) for a, b in pairwise(way)) == pytest.approx(best)
        assert np.isinf(ways.costs[np.isinf(cost)]).all()


def test_of_several_sources_the_nearest_counts() -> None:
    ways = GridWays(np.ones((1, 9)), np.array([[0, 0], [0, 8]]))
    assert ways.costs.tolist() == [[0, 1, 2, 3, 4, 3, 2, 1, 0]]
    assert ways.to(np.array([0, 6])).tolist() == [[0, 8], [0, 7], [0, 6]]


def first_found(start: Cell, wanted: set[Cell], passable: set[Cell]) -> list[Cell] | None:
    """Return the first path that a breadth-first search in the order of NEIGHBOURS finds."""
    before: dict[Cell, Cell | None] = {start: None}
    queue = deque([start])
    while queue:
        cell = queue.popleft()
        if cell in wanted:
            way = [cell]
            while (previous := before[way[-1]]) is not None:
                way.append(previous)
            return way[::-1]
        for di, dj in NEIGHBOURS:
            following = cell[0] + di, cell[1] + dj
            if following not in before and following in wanted | passable:
                before[following] = cell
                queue.append(following)
    return None


def test_the_nearest_wanted_cell_is_the_one_that_a_search_in_the_order_of_directions_finds_first() -> None:
    random = np.random.default_rng(5)
    for _ in range(300):
        kinds = random.integers(0, 3 + int(random.integers(0, 3)), (9, 9))
        passable = {tuple(cell) for cell in np.argwhere(kinds > 1).tolist()} - {(4, 4)}
        wanted = {tuple(cell) for cell in np.argwhere(kinds == 1).tolist() if random.random() < 0.3} - {(4, 4)}
        assert nearest((4, 4), wanted.__contains__, passable) == first_found((4, 4), wanted, passable)


def test_a_straightened_way_keeps_its_ends_and_only_the_corners_that_it_needs() -> None:
    grid = Grid(np.array([-2.0, 1.0]), 0.5, (20, 20))
    open_cells = np.ones(grid.shape, bool)
    open_cells[10, :15] = False

    def clear(a: np.ndarray, b: np.ndarray) -> bool:
        return bool(open_cells[tuple(grid.line(a, b).T)].all())

    first, last = np.array([2, 2]), np.array([17, 2])
    cells = GridWays(np.where(open_cells, 1.0, np.inf), first[None]).to(last)
    corners = straightened(grid.centres(cells), clear)
    assert (grid.cells_of(corners)[[0, -1]] == (first, last)).all()
    assert 3 <= len(corners) <= 5 < len(cells)
    assert all(clear(a, b) for a, b in pairwise(corners))


def test_a_grid_knows_its_cells() -> None:
    grid = Grid(np.array([10.0, -4.0, 0.0]), 2.0, (3, 2, 4))
    assert len(grid.all_centres()) == 24 and grid.holds(grid.cells_of(grid.all_centres())).all()
    assert grid.all_centres()[1].tolist() == [11.0, -3.0, 3.0], "the last axis runs fastest"
    assert grid.cells_of(np.array([[9.9, -4.0, 7.9]])).tolist() == [[-1, 0, 3]]
    assert not grid.holds(np.array([[-1, 0, 3], [0, 0, 4]])).any()


LOW, HIGH = (-6.0, -6.0, -6.0), (6.0, 6.0, 0.0)


def basin(*, wall: bool, hole_y_m: float | None = None) -> OccupancyMap:
    """Return a 12 x 12 x 6 m map of free water with a wall at x = 0, optionally with a hole 3 m wide."""
    occupancy = OccupancyMap(resolution_m=0.5)
    y, z = (part.ravel() for part in np.mgrid[-6:6:0.25, -5.9:0:0.25])
    for x_from, x_to in ((-5.75, 5.75), (5.75, -5.75)):
        x = np.full(y.shape, x_to)
        if wall:
            stopped = np.ones(len(y), bool) if hole_y_m is None else np.abs(y - hole_y_m) > 1.5
            x[stopped] = 0.1
        origins = np.column_stack([np.full(y.shape, x_from), y, z])
        occupancy.insert_scans(
            np.column_stack([x, y, z]).astype(np.float32), np.ones(len(y), np.int64), origins, threads=1
        )
    return occupancy


def test_in_free_water_the_way_is_straight() -> None:
    way = FreeWater(basin(wall=False), LOW, HIGH, 0.5).way((-4.1, -4.1, -3.1), (4.1, 4.1, -3.1))
    assert len(way) == 2
    length_m = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    assert length_m == pytest.approx(np.hypot(8.2, 8.2))


def test_the_way_leads_through_the_hole_with_clearance() -> None:
    occupancy, clearance_m = basin(wall=True, hole_y_m=3.0), 0.7
    way = FreeWater(occupancy, LOW, HIGH, clearance_m).way((-4.0, -4.0, -3.0), (4.0, -4.0, -3.0))
    assert way is not None
    places = np.concatenate([a + np.linspace(0, 1, 60)[:, None] * (b - a) for a, b in pairwise(way)])
    through = places[np.abs(places[:, 0]) < 0.3]
    assert (np.abs(through[:, 1] - 3.0) < 1.2).all()
    off_m = np.linalg.norm(places[:, None] - occupancy.occupied_voxels()[None], axis=2).min()
    assert off_m > clearance_m


def test_neither_walls_nor_unknown_water_are_passed() -> None:
    assert FreeWater(basin(wall=True), LOW, HIGH, 0.5).way((-4.0, 0.0, -3.0), (4.0, 0.0, -3.0)) is None
    assert FreeWater(OccupancyMap(resolution_m=0.5), LOW, HIGH, 0.5).way((-4, 0, -3), (4, 0, -3)) is None
    assert FreeWater(basin(wall=True, hole_y_m=3.0), LOW, HIGH, 2.0).way((-4, 0, -3), (4, 0, -3)) is None, "too narrow"


def test_a_vehicle_goes_by_the_map_and_says_when_it_knows_no_way() -> None:
    occupancy = basin(wall=True, hole_y_m=3.0)

    def mission(vehicle):
        vehicle.undock()
        yield from go_by_map(vehicle, occupancy, (3.0, -3.0, -2.0), clearance_m=0.7)
        try:
            yield from go_by_map(vehicle, occupancy, (30.0, 0.0, -3.0), margin_m=1.0, clearance_m=5.0)
        except StoppedError as stop:
            return str(stop)

    flown = uwsim.fly(mission, "pool")
    reason = flown.result
    assert reason.startswith("the map has no free path to (30.0, 0.0")
    track = flown.samples["rov"].path_world_m
    assert np.linalg.norm(track[-1] - (3.0, -3.0, -2.0)) < 0.8
    assert np.abs(track[np.abs(track[:, 0]) < 0.3][:, 1] - 3.0).max() < 1.5
    with pytest.raises(ValueError, match="must be a box"):
        FreeWater(occupancy, HIGH, LOW, 1.0)
