"""Missions reach all that a vehicle has: heads, fins, thrusters, imaging sonars, and sensors by kind, not by name."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.missions import OwnVehicle, StoppedError, aim_to, drive, goto, run, wait
from uwsim.missions.planners.area_missions import unknown_water
from uwsim.navigation.sensor_choice import altimeter, height_above_bed_m, port_proximity
from uwsim.scenario.read.assets import find_yaml
from uwsim.simulator.helm import IdleAxisWarning
from vehicle_files import OPEN_WATER


def open_water(model: str) -> uwsim.Scenario:
    vehicle = {"name": "rov", "model": model, "start": {"position_m": [0, 0, -20]}}
    return uwsim.Scenario.model_validate({**OPEN_WATER, "vehicles": [vehicle]})


def test_a_head_has_arrived_when_its_rate_says_so() -> None:
    """EM 2040 heads turn at 5 deg/s: 20 degrees take 4 s, until which the target is not the elevation."""
    sim = Simulator("pool")
    sonar = sim.rov.sonar
    start = sonar.elevation_rad
    assert sonar.is_aimed and sonar.target_elevation_rad == start
    sonar.aim(start + math.radians(20.0))
    needed_s = math.radians(20.0) / sonar.model.tilt_rate_rad_s
    sim.advance(round(needed_s - 0.1, 2))
    assert not sonar.is_aimed and sonar.target_elevation_rad == pytest.approx(start + math.radians(20.0))
    state = sim.save_state()
    sim.advance(0.2)
    assert sonar.is_aimed
    sim.restore_state(state)
    assert not sonar.is_aimed, "the target is part of the state"


def test_a_mission_waits_until_sonar_and_camera_point_there() -> None:
    def mission(vehicle):
        began_s = vehicle.time_s
        yield from aim_to(vehicle.sonar, -1.0)
        assert vehicle.sonar.elevation_rad == pytest.approx(-1.0)
        turned_s = vehicle.time_s - began_s
        yield from aim_to(vehicle.cameras["front"], pan_rad=0.5, tilt_rad=-0.2)
        assert vehicle.cameras["front"].aim_rad == pytest.approx((0.5, -0.2))
        return turned_s

    sim = Simulator("pool")
    needed_s = abs(-1.0 - sim.rov.sonar.elevation_rad) / sim.rov.sonar.model.tilt_rate_rad_s
    assert run(mission, sim.rov, sim) == pytest.approx(needed_s, abs=0.11)  # `until` checks every 0.1 s


def test_a_head_that_cannot_arrive_ends_the_wait() -> None:
    sim = Simulator("pool")
    with pytest.raises(StoppedError, match=r"'sonar' has not reached its aim after 0.5 s"):
        drive(aim_to(sim.rov.sonar, -1.5, timeout_s=0.5), sim)
    with pytest.raises(ValueError, match="either elevation_rad"):
        drive(aim_to(sim.rov.sonar, -1.5, pan_rad=0.1), sim)
    with pytest.raises(ValueError, match="needs elevation_rad"):
        drive(aim_to(sim.rov.sonar), sim)


def test_a_mission_commands_fins_and_thrusters_and_reads_them_back() -> None:
    def mission(vehicle):
        vehicle.set_fins({"top": 0.1})
        vehicle.set_thrusters({"propeller": 0.5})
        yield wait(3.0)
        assert vehicle.fins["top"] == pytest.approx(0.1)
        assert vehicle.thrusters["propeller"].command == pytest.approx(0.5)
        assert vehicle.controllable == {"surge", "roll", "pitch", "yaw"}
        return vehicle.velocity.linear_body_m_s[0]

    sim = Simulator(open_water("remus100"))
    assert run(mission, sim.rov, sim) > 0.5


def test_an_effort_that_nothing_drives_is_warned_of_once_for_each_axis() -> None:
    sim = Simulator(open_water("remus100"))
    with pytest.warns(IdleAxisWarning, match=r"'rov': effort on sway: has no effect.*drives surge, roll, pitch, yaw"):
        sim.rov.set_effort(surge=0.5, sway=0.2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.rov.set_effort(surge=0.5, sway=-0.3)
        sim.rov.set_effort(surge=0.5, yaw=0.1)
    with pytest.warns(IdleAxisWarning, match="effort on heave"):
        sim.rov.set_effort(sway=0.2, heave=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Simulator(open_water("bluerov2_heavy")).rov.set_effort(0.1, 0.1, 0.1, 0.1, 0.1, 0.1)


def test_imaging_sonars_are_placed_where_the_vehicle_assumes_it_is() -> None:
    class Lost:
        """An estimate that is 3 m east of the truth."""

        def __init__(self, hull):
            self._hull = hull
            self.velocity = hull.velocity

        @property
        def pose(self):
            pose = self._hull.pose
            shift = np.eye(4)
            shift[0, 3] = 3.0
            matrix = shift @ pose.world_from_body
            return type(pose)(matrix[:3, 3], pose.orientation_xyzw, matrix)

    sim = Simulator("pool")
    vehicle = OwnVehicle(sim.rov, sim, estimate=Lost(sim.rov))
    truth = sim.rov.imaging_sonars["forward_looking"].look()
    sonar = vehicle.imaging_sonars["forward_looking"]
    found = sonar.look()
    np.testing.assert_array_equal(found.level_db, truth.level_db)
    np.testing.assert_allclose(found.world_from_sonar[:3, 3] - truth.world_from_sonar[:3, 3], (3, 0, 0), atol=1e-9)
    np.testing.assert_allclose(sonar.world_from_sonar, found.world_from_sonar)
    assert sonar.model is sim.rov.imaging_sonars["forward_looking"].model


OTHER_NAMES = (
    "{builds_on: rov, sensors: {altitude: null, proximity_port: null, sounder: {kind: altitude},"
    " aside: {kind: proximity, position_m: [0, 0.4, 0], yaw_pitch_roll_deg: [80, 0, 0], range_max_m: 10}}}"
)


@pytest.fixture
def pool(tmp_path: Path) -> Path:
    path = tmp_path / "pool.yaml"
    path.write_text(find_yaml("pool", "scenarios").read_text().replace("model: rov", f"model: {OTHER_NAMES}"))
    return path


def test_they_are_chosen_by_kind_and_direction(pool: Path) -> None:
    with uwsim.Simulator(pool) as sim, uwsim.Simulator("pool") as packaged:
        sensors = sim.rov.sensors
        assert altimeter(sensors) is sensors["sounder"] and port_proximity(sensors) is sensors["aside"]
        assert altimeter(packaged.rov.sensors) is packaged.rov.sensors["altitude"]
        assert port_proximity(packaged.rov.sensors) is packaged.rov.sensors["proximity_port"]
        assert height_above_bed_m(sim.rov) == pytest.approx(sensors["sounder"].read())
        assert port_proximity({}) is None
    with pytest.raises(ValueError, match="no sensor of kind 'altitude'"):
        height_above_bed_m(type("Blind", (), {"sensors": {}}))


def test_moves_and_planners_fly_with_them(pool: Path) -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (-2.0, 1.0), altitude_m=2.5)
        assert height_above_bed_m(vehicle) == pytest.approx(2.5, abs=0.3)
        yield from unknown_water(vehicle, bound_m=7.0, altitude_m=2.0)

    flown = uwsim.fly(mission, pool, time_limit_s=60.0)
    assert flown.ended_because == "the time limit is reached" or not flown.ended_early
    assert flown.collisions == 0
