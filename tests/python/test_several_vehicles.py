"""Several vehicles in one scenario."""

import time
from pathlib import Path

import numpy as np
import pytest

from sea import open_water
from uwsim import Simulator
from uwsim.scenario import ScenarioError
from uwsim.scenario.read.assets import assets_folder


@pytest.fixture
def pair() -> Simulator:
    return Simulator("pair", seed=3)


def test_each_vehicle_takes_its_own_commands_and_the_first_is_rov(pair: Simulator) -> None:
    rov, scout = pair.vehicles["rov"], pair.vehicles["scout"]
    assert pair.rov is rov
    assert not rov.released and scout.released
    scout.set_effort(yaw=0.2)
    pair.advance(2.0)
    assert abs(scout.velocity.angular_body_rad_s[2]) > 0.1
    np.testing.assert_array_equal(rov.velocity.angular_body_rad_s, 0)
    assert rov.telemetry().mission_time_s == 0 and scout.telemetry().mission_time_s == pytest.approx(2.0)
    rov.release()
    rov.set_effort(surge=0.3)
    pair.advance(1.0)
    assert rov.velocity.linear_body_m_s[0] > 0.05
    np.testing.assert_array_equal(scout.effort, [0, 0, 0, 0, 0, 0.2])


def test_vehicles_collide_with_each_other_and_both_report_it(tmp_path: Path) -> None:
    sim = open_water(tmp_path, "rov", "bluerov2_heavy", density_kg_m3=13.5 / 0.0134, apart_m=3.0)
    large, small = sim.vehicles.values()
    large.set_effort(sway=0.5)
    touched = set()
    for _ in range(200):
        sim.advance(0.05)
        touched |= {vehicle.name for vehicle in (large, small) if vehicle.telemetry().collision_warning}
    assert touched == {large.name, small.name}
    assert large.collisions >= 1 and small.collisions >= 1
    assert small.pose.position_world_m[1] > 3.1, "the large one pushes it along"
    gap_m = small.pose.position_world_m[1] - large.pose.position_world_m[1]
    assert gap_m > 0.4, "neither went through the other"


def test_a_docked_vehicle_does_not_collide(pair: Simulator) -> None:
    before = pair.rov.pose.position_world_m.copy()
    pair.vehicles["scout"].place(before)
    pair.advance(1.0)
    np.testing.assert_array_equal(pair.rov.pose.position_world_m, before)
    assert pair.rov.collisions == 0


def test_identical_vehicles_have_independent_noise(tmp_path: Path) -> None:
    sim = open_water(tmp_path, "rov", "rov")
    first, second = sim.vehicles.values()
    sim.advance(1.0)
    assert first.sensors["depth"].read(noise=False) == second.sensors["depth"].read(noise=False)
    assert first.sensors["depth"].read() != second.sensors["depth"].read()


def test_a_second_vehicle_far_away_does_not_change_a_bit(tmp_path: Path) -> None:
    alone, together = open_water(tmp_path, "bluerov2_heavy"), open_water(tmp_path, "bluerov2_heavy", "remus100")
    for sim in (alone, together):
        sim.rov.set_effort(surge=0.4, yaw=0.3)
        sim.advance(5.0)
    np.testing.assert_array_equal(alone.rov.pose.world_from_body, together.rov.pose.world_from_body)


def test_the_cost_of_a_step_is_linear_in_the_number_of_vehicles(tmp_path: Path) -> None:
    """Eight times the vehicles take less than 24 times as long: far below quadratic."""

    def seconds(count: int) -> float:
        sim = open_water(tmp_path, *["bluerov2_heavy"] * count)
        for vehicle in sim.vehicles.values():
            vehicle.set_effort(heave=0.1)
        sim.step(50)
        best = np.inf
        for _ in range(5):
            start = time.perf_counter()
            sim.step(500)
            best = min(best, time.perf_counter() - start)
        return best

    assert seconds(16) < 24 * seconds(2)


def test_the_dock_holds_one_vehicle(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pair.yaml").read_text()
    path = tmp_path / "crowd.yaml"
    path.write_text(text.replace("start: {position_m: [0, 0, -5], yaw_deg: 180}", "start: station"))
    with pytest.raises(ScenarioError, match=r"vehicles\[1\]\.start.*the dock holds one vehicle"):
        Simulator(path)
