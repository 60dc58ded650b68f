"""Leaving the dock and docking again: each is reported, warned of or refused with the reason."""

import warnings

import numpy as np
import pytest

from uwsim import DockedWarning, Simulator
from uwsim.scenario import load


@pytest.fixture(scope="module")
def shared() -> Simulator:
    return Simulator("lake")


@pytest.fixture
def lake(shared: Simulator) -> Simulator:
    """The lake at its initial state."""
    fresh = shared.__dict__.setdefault("_at_start", shared.save_state())
    shared.restore_state(fresh)
    shared.rov.set_effort()
    return shared


def test_a_docked_vehicle_that_is_commanded_warns_once_when_time_passes() -> None:
    sim = Simulator("pool")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.advance(0.1)
        sim.rov.set_effort(surge=0.5)  # stored: takes effect on release
        sim.rov.set_effort()
        sim.advance(0.1)
        sim.rov.set_effort(surge=0.5)
        with pytest.raises(DockedWarning, match=r"vehicle 'rov' is docked: its commands have no effect before release"):
            sim.advance(0.1)
        sim.advance(0.1)
        sim.rov.release()
        sim.advance(1.0)
    assert sim.rov.velocity.linear_body_m_s[0] > 0.05


def test_a_docked_vehicle_that_is_placed_is_free(lake: Simulator) -> None:
    lake.rov.place([0, 0, -15], velocity_body=[0.5, 0, 0, 0, 0, 0])
    assert lake.rov.released
    assert lake.rov.velocity.linear_body_m_s[0] == 0.5
    lake.rov.set_effort(surge=0.5)
    lake.advance(2.0)
    assert lake.rov.pose.position_world_m[0] > 0.5
    assert lake.rov.telemetry().mission_time_s == pytest.approx(2.0)


def test_a_place_that_is_refused_leaves_the_vehicle_docked(lake: Simulator) -> None:
    before = lake.rov.pose.position_world_m
    with pytest.raises(ValueError, match="must be above the ground"):
        lake.rov.place([0, 0, -60])
    assert not lake.rov.released
    np.testing.assert_array_equal(lake.rov.pose.position_world_m, before)


@pytest.mark.parametrize(
    "effort", [{"surge": 0.5}, {"surge": -0.5}, {"sway": 0.5}, {"sway": -0.5}, {"heave": -0.5}], ids=str
)
def test_a_released_vehicle_leaves_its_cage_without_a_touch(lake: Simulator, effort: dict[str, float]) -> None:
    start = lake.rov.pose.position_world_m
    lake.rov.release()
    lake.rov.set_effort(**effort)
    lake.advance(12.0)
    assert np.linalg.norm(lake.rov.pose.position_world_m - start) > 3.0
    assert lake.rov.collisions == 0


@pytest.mark.parametrize("scenario", ["lake", "pool", "pair"])
def test_undocked_it_is_at_rest_in_free_water_ahead_of_the_dock(scenario: str, lake: Simulator) -> None:
    sim = lake if scenario == "lake" else Simulator(scenario)
    rov, dock = sim.rov, sim.rov.pose
    rov.undock()
    assert rov.released
    moved = rov.pose.position_world_m - dock.position_world_m
    np.testing.assert_allclose(moved, 3.0 * dock.world_from_body[:3, 0], atol=1e-9)
    np.testing.assert_array_equal(rov.velocity.linear_body_m_s, 0)
    sim.advance(2.0)
    assert rov.collisions == 0
    with pytest.raises(ValueError, match="undock: is not docked"):
        rov.undock()


def test_undocking_into_something_is_refused_and_leaves_it_docked() -> None:
    pool = load("pool")
    box = pool.obstacles[0].position_m
    x, y, z = np.subtract(box, pool.station.position_m)
    exit_m = (float(x), float(y), float(z) + 0.9)
    sim = Simulator(pool.model_copy(update={"station": pool.station.model_copy(update={"exit_m": exit_m})}))
    with pytest.raises(ValueError, match=r"vehicle 'rov': station\.exit_m: .* is not free: a surface is 0\.4"):
        sim.rov.undock()
    assert not sim.rov.released


def test_another_vehicle_may_be_in_the_way_out_or_in_the_dock() -> None:
    sim = Simulator("pair")
    rov, scout = sim.vehicles["rov"], sim.vehicles["scout"]
    dock, yaw = rov.pose.position_world_m, rov.pose.orientation_xyzw
    scout.place(dock + 3.2 * rov.pose.world_from_body[:3, 0], yaw)
    with pytest.raises(ValueError, match=r"another vehicle is 0\.20 m away"):
        rov.undock()
    scout.place(dock - (0.0, 0.0, 1.2), yaw)
    with pytest.raises(ValueError, match="vehicle 'scout': dock: occupied by another vehicle"):
        scout.dock()


def test_a_vehicle_docks_from_nearby_and_starts_afresh(lake: Simulator) -> None:
    rov, dock = lake.rov, lake.rov.pose.position_world_m
    rov.undock()
    rov.set_effort(surge=-0.1)
    while np.linalg.norm(rov.pose.position_world_m - dock) > 1.4:
        lake.advance(0.1)
        assert lake.time_s < 60
    rov.set_effort()
    assert rov.collisions == 0
    rov.dock()
    assert not rov.released
    np.testing.assert_allclose(rov.pose.position_world_m, dock, atol=1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # no warning: the earlier commands have ended
        lake.advance(1.0)
    np.testing.assert_allclose(rov.pose.position_world_m, dock, atol=1e-9)
    assert rov.telemetry().battery_percent == 100.0
    with pytest.raises(ValueError, match="dock: is docked already"):
        rov.dock()
    rov.release()
    lake.advance(2.0)
    assert rov.telemetry().mission_time_s == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("along_m", "turn_rad", "speed_m_s", "message"),
    [
        (3.0, 0.0, 0.0, r"dock: it is 3\.0 m away \(-2\.3 m east, -1\.9 m north, 0\.0 m up\), must be within 1\.5 m"),
        (1.0, 0.8, 0.0, "it points 46 degrees away from the dock's heading, 40 degrees from east"),
        (1.0, 0.0, 0.6, r"speed = 0\.60 m/s: must be at most 0\.5 m/s"),
    ],
)
def test_docking_from_afar_askew_or_fast_says_by_how_much(
    lake: Simulator, along_m: float, turn_rad: float, speed_m_s: float, message: str
) -> None:
    rov, yaw = lake.rov, lake.rov.pose.yaw_rad + turn_rad
    place = rov.pose.position_world_m + along_m * rov.pose.world_from_body[:3, 0]
    rov.place(place, [0, 0, np.sin(yaw / 2), np.cos(yaw / 2)], [speed_m_s, 0, 0, 0, 0, 0])
    with pytest.raises(ValueError, match=message):
        rov.dock()
    assert rov.released
