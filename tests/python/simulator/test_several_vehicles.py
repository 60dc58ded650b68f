"""Scenarios with several vehicles."""

import time
from pathlib import Path

import numpy as np
import pytest

from sea import open_water
from uwsim import Simulator
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.depth_map import DepthMap, ranges_m
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


def test_sonars_see_the_other_vehicle_by_name_and_not_their_own(pair: Simulator) -> None:
    rov, scout = pair.vehicles["rov"], pair.vehicles["scout"]
    assert pair.label_names[-2:] == ["rov", "scout"]
    rov.release()
    rov.place((5.0, 0.0, -5.0))
    head = rov.sonar.ping().world_from_sonar
    scout.place(head[:3, 3] + 6.0 * head[:3, 0])
    label = pair.label_names.index("scout")
    ping = rov.sonar.ping()
    seen = ping.labels == label
    assert seen.sum() > 10 and (np.abs(ping.ranges_m[seen] - 6.0) < 0.5).all()
    assert pair.label_names.index("rov") not in ping.labels
    batch = rov.sonar.ping_batch(rov.pose.world_from_body[None])
    np.testing.assert_array_equal(batch.ranges_m[0], ping.ranges_m)
    np.testing.assert_array_equal(batch.labels[0], ping.labels)
    scout.place((-20.0, 20.0, -5.0))
    away = rov.sonar.ping()
    assert label not in away.labels and (away.ranges_m[seen] > ping.ranges_m[seen]).all()
    np.testing.assert_array_equal(away.ranges_m[~seen], ping.ranges_m[~seen])


def test_imaging_sonars_and_depth_maps_see_vehicles_around_their_carrier(pair: Simulator) -> None:
    rov, scout = pair.vehicles["rov"], pair.vehicles["scout"]
    rov.release()
    rov.place((5.0, 0.0, -5.0))
    scout.place((11.0, 0.0, -5.0))
    pose, model = rov.pose.world_from_body, imaging.ForwardLooking(range_max_m=10, range_bins=100, beams=64)
    at_scout = (np.abs(np.arange(100) * 0.1 - 6.0) < 0.6, slice(28, 36))
    around, alone = (imaging.look_ahead(place, pose, model) for place in (pair.around("rov"), pair))
    assert around.level_db[at_scout].max() > alone.level_db[at_scout].max() + 20
    depth = DepthMap(width=65, field_of_view_rad=1.0, range_max_m=50.0)
    assert np.abs(ranges_m(pair.around("rov"), pose, [0.0], depth)[0] - 6.0) < 0.6
    assert ranges_m(pair, pose, [0.0], depth)[0] > 10
    assert pair.around().scene.cast([(5.0, 0.0, -1.0)], [(0.0, 0.0, -1.0)], 50.0).labels == [
        pair.label_names.index("rov")
    ]
    with pytest.raises(ValueError, match=r"vehicle = 'skout': must be one of rov, scout"):
        pair.around("skout")


def test_physics_mode_hears_the_other_vehicle(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pair.yaml").read_text()
    path = tmp_path / "heard.yaml"
    path.write_text(text.replace("sonar: {model: 2, tilt_deg: 20}", "sonar: {model: 2, tilt_deg: 20, mode: physics}"))
    sim = Simulator(path, seed=3)
    sim.rov.place((5.0, 0.0, -5.0))
    head = sim.rov.sonar.ping().world_from_sonar
    sim.vehicles["scout"].place(head[:3, 3] + 6.0 * head[:3, 0])
    ping = sim.rov.sonar.ping()
    seen = (ping.labels == sim.label_names.index("scout")) & ping.valid
    assert seen.sum() > 5 and np.abs(np.median(ping.ranges_m[seen]) - 6.0) < 0.5


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
    """With eight times the vehicles, a step takes less than 24 times as long: far below quadratic."""

    def seconds(count: int) -> float:
        sim = open_water(tmp_path, *["bluerov2_heavy"] * count)
        for vehicle in sim.vehicles.values():
            vehicle.set_effort(heave=0.1)
        sim.step(50)
        best = np.inf
        for _ in range(5):
            start = time.thread_time()  # CPU time, because the machine may be busy
            sim.step(500)
            best = min(best, time.thread_time() - start)
        return best

    assert seconds(16) < 24 * seconds(2)


def test_the_dock_holds_one_vehicle(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pair.yaml").read_text()
    path = tmp_path / "crowd.yaml"
    path.write_text(text.replace("start: {position_m: [0, 0, -5], yaw_deg: 180}", "start: station"))
    with pytest.raises(ScenarioError, match=r"vehicles\[1\]\.start.*the dock holds one vehicle"):
        Simulator(path)
