"""The lawn-mower without a polygon: it covers all reachable bed, hits nothing, and stops at every kind of edge."""

import math

import numpy as np

import uwsim
from uwsim import Simulator
from uwsim.missions import StoppedError
from uwsim.missions.planners.cells import Cells, nearest
from uwsim.missions.planners.unknown_water import mow_unknown_water

DEEP_ENOUGH_M = 6.0


def mow(bound_m: float, altitude_m: float = 3.0, **settings: float):
    def mission(vehicle):
        vehicle.undock()
        return (yield from mow_unknown_water(vehicle, bound_m, altitude_m=altitude_m, speed_m_s=0.7, **settings))

    return mission


def test_a_cove_with_an_island_is_mown_to_its_shores_without_a_collision() -> None:
    bound_m, spacing_m = 19.0, 5.0
    flown = uwsim.fly(mow(bound_m, line_spacing_m=spacing_m), "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    path = flown.samples["rov"].path_world_m[:, :2]
    start = np.array([-13.0, -14.0])
    assert np.linalg.norm(path - start, axis=1).max() < bound_m + spacing_m
    sim = Simulator("cove")
    grid = np.mgrid[-40:40:2.0, -40:40:2.0].reshape(2, -1).T
    deep = sim.world.height_at(grid) < -DEEP_ENOUGH_M
    away = sim.scene.distance_m(np.column_stack([grid, np.full(len(grid), -3.0)])) > spacing_m
    inside = np.linalg.norm(grid - start, axis=1) < bound_m - spacing_m
    wanted = grid[deep & away & inside]
    assert len(wanted) > 50
    off_m = np.array([np.linalg.norm(path - point, axis=1).min() for point in wanted])
    assert off_m.max() < 1.5 * spacing_m, f"{wanted[off_m.argmax()]} is {off_m.max():.1f} m from the path"


def test_where_the_bed_ends_it_turns_back_and_says_so() -> None:
    flown = uwsim.fly(mow(16.0, 2.0, line_spacing_m=4.0, heading_rad=0.0), "pool")  # the pool ends after 20 x 20 m
    assert not flown.ended_early, flown.ended_because
    reasons = {event.values["reason"] for event in flown.events if event.name == "closed"}
    assert "no bed below" in reasons
    assert np.abs(flown.samples["rov"].path_world_m[:, :2]).max() < 13.0


def test_a_vehicle_that_cannot_move_is_stuck_and_not_silent() -> None:
    def mission(vehicle):
        vehicle.undock()
        vehicle.__dict__["_hull"] = Held(vehicle._hull)
        try:
            yield from mow_unknown_water(vehicle, 10.0, line_spacing_m=3.0, altitude_m=2.0)
        except StoppedError as stop:
            return str(stop)

    assert uwsim.fly(mission, "pool").result.startswith("stuck at (")


class Held:
    """A vehicle whose thrusters have no effect."""

    def __init__(self, hull: object) -> None:
        self._hull = hull

    def __getattr__(self, name: str) -> object:
        return getattr(self._hull, name)

    def set_effort(self, **efforts: float) -> None:
        self._hull.set_effort()


def test_cells_are_numbered_along_the_heading_and_the_way_leads_round_what_is_closed() -> None:
    cells = Cells((3.0, -2.0), math.radians(30.0), 4.0)
    for cell in ((0, 0), (2, -3), (-5, 1)):
        assert cells.cell_of(cells.middle_m(cell)) == cell
    flown = {(0, 0), (0, 1), (1, 1), (2, 1)}
    assert nearest((0, 0), lambda c: c == (2, 0), flown) == [(0, 0), (0, 1), (1, 1), (2, 1), (2, 0)]
    assert nearest((0, 0), lambda c: c == (9, 9), flown) is None
