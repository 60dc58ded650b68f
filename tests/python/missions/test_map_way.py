"""Paths through a map: around occupied voxels, not through unknown ones, and as short as the clearance allows."""

from itertools import pairwise

import numpy as np
import pytest

import uwsim
from uwsim.mapping import OccupancyMap
from uwsim.missions import StoppedError
from uwsim.missions.planners.map_way import FreeWater, go_by_map

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
