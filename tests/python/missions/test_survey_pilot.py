"""The lawn-mower steers by the model of thrusters, or plainly without, and crosses a lake without a collision."""

import numpy as np
import pytest

from test_missions import ScriptedVehicle, wide_pool
from uwsim import Simulator
from uwsim.missions import COVERED, AdaptiveLawnMower, Lane, LawnMowerPlan
from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller, survey_pilot
from uwsim.scenario import load

PLAN = LawnMowerPlan([[-40, -10], [40, -10], [40, 10], [-40, 10]], altitude_m=2.0, speed_m_s=1.4)


def test_thrusters_are_steered_by_their_model() -> None:
    assert isinstance(survey_pilot(wide_pool("bluerov2_heavy").rov, 0.1), Controller)
    assert isinstance(survey_pilot(wide_pool("rov").rov, 0.1), Autopilot)
    assert isinstance(survey_pilot(ScriptedVehicle(), 0.1), Autopilot), "a remote vehicle tells no model"


def test_a_heavy_vehicle_stays_level_at_full_speed() -> None:
    with wide_pool("bluerov2_heavy", 45.0) as sim:
        for wait in AdaptiveLawnMower(sim.rov, sim, PLAN).steps():
            sim.wait(wait.duration_s)
            assert sim.rov.pose.world_from_body[2, 2] > 0.9, "25 degrees"


FROM, TO = np.array([-190.0, 0.0]), np.array([190.0, 0.0])
CROSSING = LawnMowerPlan([[180, -2], [190, -2], [190, 2], [180, 2]], speed_m_s=1.4, lanes=[Lane(TO, TO - [12.0, 0.0])])


class WatchedClock:
    """A clock that records, as time passes, how far ahead the middle beam meets the bed."""

    def __init__(self, sim: Simulator) -> None:
        self.sim = sim
        self.ahead_m: list[float] = []

    @property
    def time_s(self) -> float:
        return self.sim.time_s

    def wait(self, duration_s: float) -> None:
        self.sim.advance(duration_s)
        ping = self.sim.rov.sonar.ping()
        middle = len(ping.ranges_m) // 2
        if self.sim.time_s > 30.0 and self.sim.rov.pose.position_world_m[0] < 120.0:  # in open water, head tilted
            self.ahead_m.append(float(ping.ranges_m[middle] * np.cos(self.sim.rov.sonar.elevation_rad)))


def test_the_lake_is_crossed_from_shore_to_shore() -> None:
    lake = load("lake")
    terrain = lake.terrain.model_copy(update={"seed": 57})  # a ridge on the way
    sim = Simulator(lake.model_copy(update={"terrain": terrain}), threads=1)
    sim.rov.place((*FROM, float(sim.world.height_at([FROM])[0]) + 4.0))
    clock = WatchedClock(sim)
    assert AdaptiveLawnMower(sim.rov, clock, CROSSING).run() == COVERED
    assert sim.rov.collisions == 0
    assert np.median(clock.ahead_m) > 20.0, "a fan at the survey's tilt meets the bed 14 m ahead"
    assert min(clock.ahead_m) > 3.0 * stopping_distance_m(sim, CROSSING.speed_m_s)


def stopping_distance_m(sim: Simulator, speed_m_s: float) -> float:
    """Return the distance the vehicle needs to stop from a given speed."""
    rov, start_m = sim.rov, np.array([0.0, 0.0, -10.0])
    rov.place(start_m)
    autopilot = Autopilot(rov)
    for _ in range(200):
        autopilot.steer(0.0, (speed_m_s, 0.0), -10.0)
        sim.advance(0.1)
    assert rov.velocity.linear_body_m_s[0] == pytest.approx(speed_m_s, abs=0.05)
    begun_m = rov.pose.position_world_m[0]
    for _ in range(100):
        autopilot.steer(0.0, (0.0, 0.0), -10.0)
        sim.advance(0.1)
    return float(rov.pose.position_world_m[0] - begun_m)
