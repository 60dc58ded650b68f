"""Thruster and fin commands through the public API."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import sites
from sea import open_water
from uwsim import Simulator, _core
from uwsim.base.axes import AXES
from uwsim.scenario import ScenarioError, load_vehicle
from uwsim.scenario.build.equipment import thrust_curve
from uwsim.scenario.spec.actuator import ThrusterType, load_thruster
from uwsim.simulator.vehicle import Vehicle

T200_PWM_N = {1100: -39.9, 1200: -26.6, 1300: -14.1, 1400: -4.71, 1600: 5.88, 1700: 17.85, 1800: 33.5, 1900: 51.5}


@pytest.fixture
def heavy(tmp_path: Path) -> Simulator:
    return open_water(tmp_path, "bluerov2_heavy")


def test_the_t200_curve_passes_through_the_published_points() -> None:
    curve = thrust_curve(load_thruster("t200_16v"))
    for pwm, thrust in T200_PWM_N.items():
        assert curve.thrust_n((pwm - 1500) / 400) == pytest.approx(thrust, abs=1e-12)
    assert {curve.thrust_n((pwm - 1500) / 400) for pwm in (1472, 1490, 1500, 1528)} == {0}


@pytest.mark.parametrize(
    ("thrust_n", "message"),
    [
        ("[[-1, -5], [0, 0], [1, -2]]", "thrusts must not fall"),
        ("[[-1, -5], [0, 1], [1, 2]]", "command 0 must give 0 N"),
        ("[[0, 0], [2, 2]]", r"commands must be in \[-1, 1\]"),
        ("[[0, 0]]", "must have at least 2 items"),
        ("{kind: speed, max_rpm: 0, diameter_m: 0.1, thrust_coefficient: 0.4}", "max_rpm = 0 rpm: must be in"),
    ],
)
def test_an_invalid_curve_is_refused_with_file_and_line(tmp_path: Path, thrust_n: str, message: str) -> None:
    path = tmp_path / "odd.yaml"
    path.write_text(f"name: odd\nthrust_n: {thrust_n}\ntime_constant_s: 0.1\ndiameter_m: 0.1\n")
    with pytest.raises(ScenarioError, match=rf"odd\.yaml:2: thrust_n.*{message}"):
        load_thruster(path)


def test_a_thruster_by_its_speed_gives_the_published_thrust() -> None:
    law = {"kind": "speed", "max_rpm": 3533, "diameter_m": 0.076, "thrust_coefficient": 0.445, "astern": 0.775}
    given = {"name": "t200", "time_constant_s": 0.076, "diameter_m": 0.076, "thrust_n": law | {"dead_band": 0.07}}
    curve = thrust_curve(ThrusterType.model_validate(given | {"pwm": {"centre_us": 1500, "span_us": 400}}))
    got = [curve.thrust_n(command) for command in (1.0, 0.5, 0.06, 0.0, -1.0)]
    assert got == pytest.approx((51.5, 51.5 / 4, 0, 0, -39.9), rel=2e-3)  # Blue Robotics' bench, at 3533 rpm


def wrench_of(rov: Vehicle) -> np.ndarray:
    """Return the still-water wrench of the current thrusts, computed from the mounts in the vehicle's file."""
    mounts = load_vehicle("bluerov2_heavy").thrusters
    total = np.zeros(6)
    for name, thruster in rov.thrusters.items():
        axis = np.asarray(mounts[name].axis, float) / np.linalg.norm(mounts[name].axis)
        total += thruster.thrust_n * np.r_[axis, np.cross(mounts[name].position_m, axis)]
    return total


def test_the_thrusters_give_the_commanded_wrench(heavy: Simulator) -> None:
    wanted = np.array([20.0, -15.0, 30.0, 2.0, -1.0, 3.0])
    heavy.rov.set_wrench(wanted[:3], wanted[3:])
    heavy.advance(3.0)
    np.testing.assert_allclose(wrench_of(heavy.rov), wanted, atol=1e-9)
    heavy.rov.set_wrench(50 * wanted[:3], 50 * wanted[3:])
    heavy.advance(3.0)
    got = wrench_of(heavy.rov)
    np.testing.assert_allclose(got / np.linalg.norm(got), wanted / np.linalg.norm(wanted), atol=1e-9)
    assert max(abs(thruster.command) for thruster in heavy.rov.thrusters.values()) == pytest.approx(1.0)


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("share", [1.0, -1.0, 0.5, -0.5])
def test_full_effort_is_the_largest_wrench_of_one_axis(heavy: Simulator, axis: int, share: float) -> None:
    heavy.rov.set_effort(**{AXES[axis]: share})
    heavy.advance(3.0)
    expected = np.zeros(6)
    expected[axis] = share * heavy.rov.full_wrench_body[0 if share > 0 else 1][axis]
    np.testing.assert_allclose(wrench_of(heavy.rov), expected, atol=1e-9)


def test_thrust_follows_the_command_with_the_lag_of_its_file(heavy: Simulator) -> None:
    heavy.rov.set_thrusters({"rear_left": 0.75})
    heavy.step(1)
    first = heavy.rov.thrusters["rear_left"]
    assert first.command == 0.75
    assert first.thrust_n == pytest.approx(33.5 * (1 - np.exp(-0.005 / 0.076)), rel=1e-9)
    assert heavy.rov.thrusters["rear_right"].thrust_n == 0
    heavy.advance(2.0)
    assert heavy.rov.thrusters["rear_left"].thrust_n == pytest.approx(33.5)


def test_a_neutral_vehicle_without_a_command_stays_where_it_is(tmp_path: Path) -> None:
    sim = open_water(tmp_path, "bluerov2_heavy", density_kg_m3=13.5 / 0.0134)
    sim.rov.set_effort()
    sim.advance(10.0)
    np.testing.assert_allclose(sim.rov.pose.position_world_m, [0, 0, -30], atol=1e-6)


def test_a_propellers_torque_heels_the_hull_against_its_spin(tmp_path: Path) -> None:
    sim = open_water(tmp_path, "remus100", density_kg_m3=1026.0)
    sim.rov.set_thrusters({"propeller": 1.0})
    sim.advance(2.0)
    assert sim.rov.pose.world_from_body[2, 1] > 0.05, "the propeller turns left-handed: heel to starboard, port side up"


def test_thrusters_above_the_surface_have_no_effect(heavy: Simulator) -> None:
    heavy.rov.place((0.0, 0.0, 3.0))
    heavy.rov.set_effort(surge=1.0)
    heavy.advance(0.5)
    assert abs(heavy.rov.velocity.linear_body_m_s[0]) < 1e-9


def test_fins_turn_at_their_rate_and_return_to_zero(tmp_path: Path) -> None:
    sim = open_water(tmp_path, "remus100")
    assert set(sim.rov.fins) == {"port", "starboard", "top", "bottom"}
    sim.rov.set_fins({"top": 0.2})
    sim.advance(0.05)
    assert sim.rov.fins["top"] == pytest.approx(np.radians(90) * 0.05)
    sim.advance(0.2)
    assert sim.rov.fins == pytest.approx({"port": 0, "starboard": 0, "top": 0.2, "bottom": 0})
    sim.rov.set_fins({})
    sim.advance(0.2)
    assert sim.rov.fins["top"] == 0


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (lambda v: v.set_thrusters({"propeler": 0.5}), r"thrusters = 'propeler': must be one of propeller"),
        (lambda v: v.set_thrusters({"propeller": 1.01}), r"thrusters\.propeller = 1\.01: must be in \[-1, 1\]"),
        (lambda v: v.set_thrusters({"propeller": float("nan")}), r"thrusters\.propeller = -?nan: must be in \[-1, 1\]"),
        (lambda v: v.set_fins({"top": 0.5}), r"fins\.top = 0\.5 rad: must be in \[-0\.26.*\] rad"),
        (lambda v: v.set_fins({"hull_lateral": 0.0}), r"fins = 'hull_lateral': must be one of port, starboard, top"),
        (lambda v: v.set_wrench([1.0, 2.0]), r"force_body_n\.shape = \(2,\): expected \(3,\)"),
        (lambda v: v.set_wrench([np.inf, 0.0, 0.0]), r"wrench_body = .*: must be finite"),
        (lambda v: v.set_effort(yaw=-1.5), r"effort\.yaw = -1\.5: must be in \[-1, 1\]"),
        (lambda v: v.set_effort(heave=float("nan")), r"effort\.heave = -?nan: must be in \[-1, 1\]"),
        (lambda v: v.set_effort(heave=float("inf")), r"effort\.heave = inf: must be in \[-1, 1\]"),
    ],
)
def test_an_invalid_command_raises_one_clear_error_and_changes_nothing(
    tmp_path: Path, command: Callable[[Vehicle], None], message: str
) -> None:
    sim = open_water(tmp_path, "remus100")
    sim.rov.set_effort(surge=0.5, yaw=0.5)
    before = (sim.rov.thrusters, sim.rov.effort.tolist())
    with pytest.raises(ValueError, match=message):
        command(sim.rov)
    assert (sim.rov.thrusters, sim.rov.effort.tolist()) == before


def test_a_vehicle_without_thrusters_or_fins_takes_wrenches(tmp_path: Path) -> None:
    sim = open_water(tmp_path, "rov")
    assert sim.rov.thrusters == {} and sim.rov.fins == {}
    assert sim.rov.controllable == set(AXES)
    with pytest.raises(ValueError, match="the vehicle has none"):
        sim.rov.set_thrusters({"main": 0.1})
    sim.rov.set_wrench([400.0, 0.0, 0.0])
    sim.advance(1.0)
    by_wrench = sim.rov.velocity.linear_body_m_s[0]
    other = open_water(tmp_path, "rov")
    other.rov.set_effort(surge=0.5)
    other.advance(1.0)
    assert by_wrench == pytest.approx(other.rov.velocity.linear_body_m_s[0], rel=1e-12)


def test_the_command_for_a_thrust_gives_that_thrust() -> None:
    curve = _core.ThrustCurve([-1.0, -0.1, 0.1, 1.0], [-4.0, 0.0, 0.0, 5.0])
    for thrust in (-4.0, -1.0, 0.0, 2.5, 5.0):
        assert curve.thrust_n(curve.command(thrust)) == pytest.approx(thrust)


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
