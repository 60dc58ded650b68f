"""Inspections in the cove: walls are scanned, gates passed in their middle, and weak places of a map flown again."""

import math
from itertools import pairwise

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.mapping import OccupancyMap
from uwsim.mapping.changes import map_changes
from uwsim.missions import StoppedError, goto, run, turn_to
from uwsim.missions.planners import next_best_view
from uwsim.missions.planners.gate import gate_posts, pass_gate
from uwsim.missions.planners.twin import make_twin
from uwsim.missions.planners.wall import scan_wall

GATE_M, GATE_WIDTH_M, GATE_HEIGHT_M = np.array([-4.0, 2.0]), 4.0, 4.0


def test_a_gate_is_passed_in_its_middle_from_both_sides() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-13.0, 0.0), altitude_m=3.0)
        there = yield from pass_gate(vehicle, GATE_M + 1.0, GATE_WIDTH_M, GATE_HEIGHT_M)
        back = yield from pass_gate(vehicle, GATE_M + 1.0, GATE_WIDTH_M, GATE_HEIGHT_M)
        return there, back

    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    for gate, heading_rad in zip(flown.result, (0.0, math.pi), strict=True):
        assert np.linalg.norm(gate.middle_m - GATE_M) < 0.3
        assert abs(math.remainder(gate.heading_rad - heading_rad, 2.0 * math.pi)) < math.radians(5.0)
    path = flown.samples["rov"].path_world_m
    through = [
        a + (GATE_M[0] - a[0]) / (b[0] - a[0]) * (b - a) for a, b in pairwise(path) if (a[0] < -4) != (b[0] < -4)
    ]
    assert len(through) == 2
    for point in through:
        assert abs(point[1] - GATE_M[1]) < 0.7 and point[2] < -9.0 + GATE_HEIGHT_M + 1.0


def test_a_missing_gate_is_an_end_with_a_reason() -> None:
    def mission(vehicle):
        vehicle.undock()
        try:
            yield from pass_gate(vehicle, (-4.0, -2.0), 2.0, 3.0)
        except StoppedError as stop:
            return str(stop)

    assert uwsim.fly(mission, "cove").result.startswith("no gate of 2 m is seen near")


def test_posts_make_a_gate_only_at_its_width() -> None:
    posts = np.array([[5.0, -1.0], [5.0, 3.0], [9.0, 3.0]])
    assert gate_posts(posts, np.array([5.0, 1.0]), 4.0) == pytest.approx(np.array([[5.0, 3.0], [5.0, -1.0]]))
    assert gate_posts(posts, np.array([5.0, 1.0]), 2.0) is None
    assert gate_posts(posts[:0], np.array([5.0, 1.0]), 4.0) is None


def test_an_exploration_under_all_stop_ends_with_the_reason(monkeypatch) -> None:
    """A view without a way is given up for the next; a vehicle that may not move has no next one."""
    sim, view = uwsim.Simulator("pool"), next_best_view._view

    def stopped_view(vehicle, live, goal):
        vehicle.all_stop()
        yield from view(vehicle, live, goal)

    def mission(vehicle):
        return (yield from next_best_view.next_best_view(vehicle))

    monkeypatch.setattr(next_best_view, "_view", stopped_view)
    with pytest.raises(StoppedError, match=r"^all stop is set$"):
        run(mission, sim.rov, sim)


QUAY_Y_M, QUAY_EAST_M = 17.5, 0.0


def test_a_quay_is_scanned_with_the_sonar_tilted_up_and_down() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-8.0, 11.0, -3.0), speed_m_s=0.8)
        yield from turn_to(vehicle, 0.4 * np.pi)  # not quite perpendicular to the wall
        return (yield from scan_wall(vehicle, 5.0, depths_m=(2.0, 4.0), tilts_deg=(-15.0, 15.0)))

    flown = uwsim.fly(mission, "cove")
    assert not flown.ended_early, flown.ended_because
    assert flown.collisions == 0
    assert [(p.depth_m, p.tilt_deg) for p in flown.result] == [(2.0, -15.0), (2.0, 15.0), (4.0, -15.0), (4.0, 15.0)]
    for scan in flown.result:
        assert scan.distance_rms_m < 0.3 and not scan.wall_ended and scan.length_m == pytest.approx(5.0, abs=0.3)
    starts_s = [event.time_s for event in flown.events if event.name == "pass"]
    samples = flown.samples["rov"]
    during = samples["time_s"] > starts_s[0]
    assert np.abs(QUAY_Y_M - samples["y_m"][during] - 4.0).max() < 0.7, "true distance"


def test_where_the_wall_ends_the_pass_ends() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-4.0, 13.0, -3.0), speed_m_s=0.8)
        yield from turn_to(vehicle, 0.5 * np.pi)
        return (yield from scan_wall(vehicle, 12.0, distance_m=3.0, depths_m=(2.0,), tilts_deg=(0.0,)))

    (scan,) = uwsim.fly(mission, "cove").result
    assert scan.wall_ended and scan.length_m < 9.0


def test_without_a_wall_it_says_so() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from scan_wall(vehicle, 5.0)

    assert uwsim.fly(mission, "cove").ended_because == "no wall is seen within 10 m ahead"


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
