"""Missions reach everything a vehicle has: heads that turn slowly, fins, thrusters and imaging sonars."""

import math
import warnings

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.remote import LockstepClock, RemoteConnection, RemoteVehicle
from uwsim.live import LiveSimulator
from uwsim.missions import OwnVehicle, StoppedError, aim_to, drive, run, wait
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


def test_a_remote_vehicle_aims_and_looks_like_the_simulated_one() -> None:
    with LiveSimulator(Simulator("pool"), paused=True) as live, RosbridgeServer(live) as server:
        rov = live.simulator.rov
        with RemoteConnection(server.url) as connection:
            far, clock = RemoteVehicle(connection), LockstepClock(connection, "odom")
            far.release()

            def mission(vehicle):
                yield from aim_to(vehicle.sonar, -0.7)
                yield from aim_to(vehicle.cameras["front"], pan_rad=0.3)
                return vehicle.imaging_sonars["forward_looking"].ping()

            image = run(mission, far, clock)
            assert rov.sonar.elevation_rad == pytest.approx(-0.7) and rov.cameras["front"].aim_rad[0] == pytest.approx(
                0.3
            )
            clock.wait(1.0)
            image, truth = far.imaging_sonars["forward_looking"].ping(), rov.imaging_sonars["forward_looking"].look()
            assert image.level_db.shape == truth.level_db.shape
            assert image.bearings_rad == pytest.approx(truth.bearings_rad, abs=1e-6)
            assert image.world_from_sonar == pytest.approx(truth.world_from_sonar, abs=0.05), "a moment ago"
            with pytest.raises(ValueError, match="no motor: there is no topic 'camera/down/cmd_pan'"):
                far.cameras["down"].aim(pan_rad=0.1)
