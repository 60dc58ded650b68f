"""A failsafe acts in simulated time, by fixed rules, identically in every run."""

import math

import numpy as np
import pytest

from sites import deep_lake
from uwsim import Simulator
from uwsim.navigation.estimation import Start
from uwsim.scenario.read.errors import ScenarioError
from uwsim.simulator.failures.manoeuvres import ascent
from uwsim.simulator.helm import FailsafeWarning

SILENCE_S = 2.0


def lake(**failsafe):
    return deep_lake(failsafe=failsafe, yaw_deg=30.0)


def test_silence_is_counted_from_the_last_command_and_ended_by_the_next():
    sim = Simulator(lake(silence_s=SILENCE_S, then="hold"))
    sim.advance(1.0)
    sim.rov.set_effort(surge=0.5)
    sim.advance(SILENCE_S)
    assert sim.rov.failsafe.state == ""
    sim.step()
    assert (sim.rov.failsafe.state, sim.rov.failsafe.cause) == ("hold", "silence")
    (event,) = sim.events
    assert (event.name, event.time_s) == ("failsafe", pytest.approx(1.0 + SILENCE_S))
    sim.advance(1.0)
    sim.rov.set_effort(sway=0.4)
    assert sim.rov.failsafe.state == ""
    assert sim.rov.effort.tolist() == [0.0, 0.4, 0.0, 0.0, 0.0, 0.0]
    assert [event.name for event in sim.events] == ["failsafe", "failsafe_ends"]


def test_hold_keeps_depth_heading_and_place():
    sim = Simulator(lake(silence_s=SILENCE_S, then="hold"))
    sim.parameters["water.current_world_m_s"] = [0.2, -0.1, 0.0]
    sim.rov.set_effort(surge=1.0, yaw=0.2)
    sim.advance(SILENCE_S + 0.005)
    began = sim.rov.pose
    sim.advance(60.0)
    assert sim.rov.failsafe.state == "hold"
    assert sim.rov.pose.position_world_m == pytest.approx(began.position_world_m, abs=0.5)
    assert math.remainder(sim.rov.pose.yaw_rad - began.yaw_rad, 2 * math.pi) == pytest.approx(0.0, abs=0.05)


def test_a_vehicle_that_navigates_returns_to_where_it_believes_home_to_be():
    sim = Simulator(lake(silence_s=SILENCE_S, then="return", speed_m_s=0.8))
    home = sim.rov.pose.position_world_m
    sim.rov.place((-50.0, -34.0, -13.0))
    estimate = sim.rov.start_navigation()
    sim.parameters["rov.sensors.usbl.on"] = False
    estimate.restart(Start((-46.0, -34.0, -13.0), 0.1))  # 4 m off the true position
    sim.advance(60.0)
    assert np.linalg.norm(estimate.pose.position_world_m - home) < 1.0
    assert sim.rov.pose.position_world_m - estimate.pose.position_world_m == pytest.approx([-4.0, 0.0, 0.0], abs=0.5)


def test_surface_ascends_at_the_stated_rate_and_stays_there():
    sim = Simulator(lake(silence_s=SILENCE_S, then="surface", ascent_m_s=0.25, surface_m=1.0))
    sim.advance(SILENCE_S + 36.0)
    assert sim.rov.pose.position_world_m[2] == pytest.approx(-12.0 + 0.25 * 36.0, abs=0.4)
    sim.advance(60.0)
    assert sim.rov.pose.position_world_m[2] == pytest.approx(-1.0, abs=0.1)


def test_return_flies_back_to_where_it_was_released():
    sim = Simulator(lake(silence_s=SILENCE_S, then="return", speed_m_s=0.8))
    home = sim.rov.pose.position_world_m
    sim.rov.place((-45.0, -30.0, -15.0))
    sim.rov.set_effort()
    sim.advance(90.0)
    assert np.linalg.norm(sim.rov.pose.position_world_m - home) < 1.0
    assert sim.rov.collisions == 0


def test_go_on_leaves_the_commands_as_they_are():
    sim = Simulator(lake(silence_s=SILENCE_S, then="go_on"))
    sim.rov.set_effort(surge=0.3)
    sim.advance(SILENCE_S + 1.0)
    assert sim.rov.failsafe.state == "go_on"
    assert sim.rov.effort[0] == 0.3


def test_a_low_battery_takes_the_vehicle_until_it_is_overridden():
    scenario = lake(battery_percent=50.0, battery_then="surface")
    sim = Simulator(scenario, mission_time_s=60.0)
    sim.rov.set_effort(surge=0.2)
    sim.advance(29.0)
    assert sim.rov.failsafe.state == ""
    sim.advance(2.0)
    assert (sim.rov.failsafe.state, sim.rov.failsafe.alarms) == ("surface", ("battery low",))
    with pytest.warns(FailsafeWarning, match="its failsafe steers \\(surface: battery\\)"):
        sim.rov.set_effort(surge=1.0)
    assert sim.rov.effort[0] != 1.0
    sim.rov.override_failsafe()
    sim.advance(2.0)
    sim.rov.set_effort(surge=1.0)
    assert sim.rov.effort[0] == 1.0
    assert sim.rov.failsafe.state == ""


@pytest.mark.parametrize(
    ("failsafe", "message"),
    [
        ({"then": "hold"}, "monitors nothing"),
        ({"silence_s": 0.0}, "0.1"),
        ({"silence_s": 5.0, "then": "panic"}, "'hold', 'surface', 'return' or 'go_on'"),
    ],
)
def test_mistakes_are_met_at_the_door(failsafe, message):
    with pytest.raises((ScenarioError, ValueError), match=message):
        lake(**failsafe)


def test_a_vehicle_without_one_says_so():
    sim = Simulator("pool")
    assert sim.rov.failsafe is None
    with pytest.raises(ValueError, match="it has no failsafe"):
        sim.rov.override_failsafe()


@pytest.mark.parametrize(("height_m", "rate_m_s"), [(10.0, 0.5), (0.3, 0.5), (4.0, 0.02)])
def test_an_ascent_never_passes_its_end_and_its_rate_is_its_height_s_derivative(height_m, rate_m_s):
    times_s = np.arange(0.0, height_m / rate_m_s + 10.0, 0.01)
    risen_m, rates_m_s = np.array([ascent(height_m, rate_m_s, time_s) for time_s in times_s]).T
    assert risen_m[-1] == pytest.approx(height_m) and rates_m_s[-1] == 0.0
    assert risen_m.max() <= height_m and rates_m_s.max() <= rate_m_s
    np.testing.assert_allclose(np.diff(risen_m) / 0.01, (rates_m_s[1:] + rates_m_s[:-1]) / 2.0, atol=1e-3)
