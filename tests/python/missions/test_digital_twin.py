"""The digital twin: repeated flights improve the map, the vehicle finishes docked, and changes are detected."""

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.mapping import OccupancyMap
from uwsim.mapping.changes import map_changes
from uwsim.missions.planners.twin import make_twin

AREA_M = [[-14, -20], [-2, -20], [-2, -10], [-14, -10]]


def test_weak_places_are_flown_again_and_the_vehicle_docks() -> None:
    def mission(vehicle):
        return (yield from make_twin(vehicle, AREA_M, most_patches=8))

    sim = Simulator("cove")
    flown = uwsim.fly(mission, sim)
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    twin = flown.result
    assert twin.docked and not sim.rov.released
    assert 0 < twin.patches <= 8
    assert twin.weak_after < 0.8 * twin.weak_before
    off_m = sim.scene.distance_m(twin.map.occupied_voxels())
    assert np.quantile(off_m, 0.95) < twin.map.resolution_m
    assert map_changes(twin.first_map, twin.map) == [], "nothing changed between the two halves of one flight"


def bed_with(*boxes: tuple[float, float]) -> OccupancyMap:
    """Return a map of a bed at z = -5, seen from above, with 1 m x 1 m x 1 m boxes on it."""
    occupancy = OccupancyMap(resolution_m=0.25)
    x, y = (part.ravel() for part in np.mgrid[-4:4:0.125, -4:4:0.125])
    z = np.full(x.shape, -5.1)
    for east, north in boxes:
        z[np.maximum(np.abs(x - east), np.abs(y - north)) < 0.5] = -4.1
    occupancy.insert_scan(np.column_stack([x, y, z]).astype(np.float32), (0.0, 0.0, -0.6))
    return occupancy


def test_what_appeared_and_vanished_is_found_where_it_is() -> None:
    both = map_changes(bed_with((-2.0, 1.0)), bed_with((2.0, -1.0)))
    places = {change.kind: change.middle_world_m[:2] for change in both}
    assert places["appeared"] == pytest.approx(np.array([2.0, -1.0]), abs=0.4)
    assert places["vanished"] == pytest.approx(np.array([-2.0, 1.0]), abs=0.4)
    assert all((change.size_m[:2] < 1.3).all() for change in both)
    assert map_changes(bed_with((1.0, 1.0)), bed_with((1.0, 1.0))) == []
    assert map_changes(OccupancyMap(resolution_m=0.25), bed_with((1.0, 1.0))) == [], "seen once is no change"


def test_maps_of_different_grids_and_impossible_certainties_are_refused() -> None:
    with pytest.raises(ValueError, match="resolution"):
        map_changes(OccupancyMap(resolution_m=0.25), OccupancyMap(resolution_m=0.5))

    def mission(vehicle):
        yield from make_twin(vehicle, AREA_M, certain=1.0)

    with pytest.raises(ValueError, match=r"certain = 1.0: must be above 0.5"):
        uwsim.fly(mission, "cove")
