"""A boat with one propeller and a rudder in its slipstream, built on the packaged one."""

import numpy as np
import pytest

import sites
from uwsim import Simulator
from uwsim.scenario import ScenarioError

RUDDER = {
    "position_m": [-1.0, 0, -0.15], "span": [0, 0, 1], "area_m2": 0.02, "aspect_ratio": 2, "parasitic_drag": 0.01,
    "stall_angle_deg": 20, "deflection_max_deg": 35,
}  # fmt: skip
JET = {"slipstream_of": "propeller"}


def lake(**rudder: object) -> Simulator:
    """A boat on a lake, its propeller under the middle of its stern and its rudder behind it."""
    propeller = {"model": "otter_propeller", "position_m": [-0.8, 0, -0.15], "axis": [1, 0, 0]}
    thrusters = {"port": None, "starboard": None, "propeller": propeller}
    model = {"builds_on": "otter", "thrusters": thrusters, "fins": {"rudder": RUDDER | rudder}}
    return Simulator(sites.lake(model), seed=1)


def turned(sim: Simulator, thrust: float, rudder_rad: float, duration_s: float) -> tuple[float, float]:
    """Return the speed and the turning rate to port after that long."""
    sim.rov.set_thrusters({"propeller": thrust})
    sim.rov.set_fins({"rudder": rudder_rad})
    sim.advance(duration_s)
    linear, angular = sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s
    return float(np.hypot(*linear[:2])), float(angular[2])


@pytest.mark.parametrize("side", [-1, 1])
def test_from_rest_it_turns_by_its_jet_and_not_without_one(side: int) -> None:
    """A positive deflection is right-handed about the span, which points up, and turns the boat to starboard."""
    _, with_jet = turned(lake(**JET), 0.5, side * 0.4, 1.0)
    _, without = turned(lake(), 0.5, side * 0.4, 1.0)
    assert side * with_jet < -0.01
    assert abs(with_jet) > 3.0 * abs(without)
    speed_m_s, still = turned(lake(**JET), 0.0, side * 0.4, 1.0)
    assert abs(still) < 1e-4 and speed_m_s < 0.01, "neither speed nor thrust"


def test_its_circle_is_narrower_in_the_jet_and_as_wide_to_either_side() -> None:
    circles_m = {}
    for name, rudder, side in (("port", JET, -1), ("starboard", JET, 1), ("no jet", {}, 1)):
        speed_m_s, rate_rad_s = turned(lake(**rudder), 0.5, side * 0.4, 60.0)
        circles_m[name] = 2.0 * speed_m_s / abs(rate_rad_s)
    assert circles_m["port"] == pytest.approx(circles_m["starboard"], rel=0.01)
    assert circles_m["port"] < 0.8 * circles_m["no jet"]


def test_a_yaw_effort_turns_the_rudder_so_that_the_boat_turns_to_port() -> None:
    sim = lake(**JET)
    sim.rov.set_effort(surge=0.5, yaw=1.0)
    sim.advance(20.0)
    assert sim.rov.fins["rudder"] == pytest.approx(-np.radians(35.0))
    assert sim.rov.velocity.angular_body_rad_s[2] > 0.05


@pytest.mark.parametrize("name", ["rudder", "propellor"])
def test_a_jet_of_no_propeller_is_refused_in_one_line(name: str) -> None:
    with pytest.raises(
        ScenarioError, match=f"slipstream_of = '{name}': must be a thruster with a propeller: propeller"
    ):
        lake(slipstream_of=name)
