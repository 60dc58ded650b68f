"""The control laws, each compared with its closed form."""

import math

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.navigation.control import Controller
from uwsim.scenario import ScenarioError, VehicleModel, control_settings, load_vehicle


def test_line_of_sight_comes_to_the_path_as_its_law_says() -> None:
    """dy/dt = -U y / sqrt(y^2 + D^2) integrates to r + D ln(y / (D + r)) = const - U t, r = sqrt(y^2 + D^2)."""
    speed, lookahead, period = 1.0, 4.0, 0.01
    follower = _core.PathFollower([[0, 0, -5], [1000, 0, -5]], lookahead, 0.0, period)

    def law(y: float) -> float:
        r = math.hypot(y, lookahead)
        return r + lookahead * math.log(y / (lookahead + r))

    at = np.array([0.0, 6.0, -5.0])
    started = law(6.0)
    for k in range(2000):
        assert law(at[1]) == pytest.approx(started - speed * k * period, abs=0.02)
        course = follower.guide(at).course_rad
        at += speed * period * np.array([math.cos(course), math.sin(course), 0.0])
    assert at[1] < 0.1


def test_the_integral_brings_a_vehicle_to_the_path_that_a_current_pushes_off() -> None:
    """Without the integral, sin(course) = drift / speed would remain as an offset: y = D tan(asin(drift / speed))."""
    speed, drift, lookahead, period = 1.0, 0.4, 4.0, 0.05
    left = {}
    for integral in (0.0, 0.4):
        follower = _core.PathFollower([[0, 0, 0], [1000, 0, 0]], lookahead, integral, period)
        at = np.array([0.0, 3.0, 0.0])
        for _ in range(6000):
            course = follower.guide(at).course_rad
            at += period * np.array([speed * math.cos(course), speed * math.sin(course) + drift, 0.0])
            at[0] %= 500.0
        left[integral] = at[1]
    assert left[0.0] == pytest.approx(lookahead * math.tan(math.asin(drift / speed)), rel=1e-3)
    assert left[0.4] == pytest.approx(0.0, abs=1e-3)


def test_a_path_goes_round_its_corners_and_ends() -> None:
    follower = _core.PathFollower([[0, 0, -1], [10, 0, -3], [10, 10, -3]], 2.0, 0.0, 0.1)
    middle = follower.guide([5, 1, 0])
    assert (middle.cross_track_m, middle.along_m, middle.left_m, middle.z_world_m) == pytest.approx((1, 5, 15, -2))
    assert follower.guide([10.5, 0, 0]).path_rad == pytest.approx(math.pi / 2)
    assert not follower.guide([10, 9.9, 0]).is_done
    assert follower.guide([10, 10.1, 0]).is_done
    with pytest.raises(ValueError, match=r"points_m\[1\]"):
        _core.PathFollower([[0, 0, 0], [0, 0, -5]], 2.0, 0.0, 0.1)


@pytest.fixture(scope="module")
def heavy() -> Simulator:
    return deep_water(load_vehicle("bluerov2_heavy"))


def still_wrench(sim: Simulator) -> np.ndarray:
    """Return the thrusters' wrench in body axes, without the propellers' torque, which the allocation ignores."""
    total = np.zeros(6)
    for name, mount in load_vehicle("bluerov2_heavy").thrusters.items():
        axis = np.array(mount.axis, float) / np.linalg.norm(mount.axis)
        total += sim.rov.thrusters[name].thrust_n * np.concatenate([axis, np.cross(mount.position_m, axis)])
    return total


@pytest.mark.parametrize("wanted", [[40, -25, 30, 1, -2, 3], [5, 0, 0, 0, 0, 0], [0, 0, -20, 0, 4, 0]])
def test_allocated_efforts_give_the_wanted_wrench(heavy: Simulator, wanted: list[float]) -> None:
    model = heavy.rov.control.model
    assert model.reachable(wanted) == pytest.approx(wanted)
    heavy.rov.place(START_M)
    heavy.rov.set_effort(*model.effort(wanted).tolist())
    heavy.advance(3.0)  # 40 time constants of the thrusters
    assert still_wrench(heavy) == pytest.approx(wanted, abs=1e-6)


def test_a_controller_stays_at_its_place_in_a_steady_current() -> None:
    sim = deep_water(load_vehicle("bluerov2_heavy"))
    sim.parameters["water.current_world_m_s"] = (0.3, 0.3, 0.0)
    sim.rov.place(START_M)
    controller = Controller(sim.rov)
    for _ in range(600):
        controller.hold(START_M, 1.0)
        sim.advance(controller.period_s)
    assert sim.rov.pose.position_world_m == pytest.approx(START_M, abs=0.01)
    assert sim.rov.pose.yaw_rad == pytest.approx(1.0, abs=0.01)


def test_a_controller_goes_on_from_its_memory() -> None:
    sim = deep_water(load_vehicle("rov"))
    first, second = Controller(sim.rov), Controller(sim.rov)
    for k in range(20):
        first.hold([1.0, 2.0, -399.0], 0.3)
        if k > 10:
            second.hold([1.0, 2.0, -399.0], 0.3)
        if k == 10:
            second.memory = first.memory
        sim.advance(0.1)
    assert second.memory == pytest.approx(first.memory, abs=1e-15)


def test_gains_are_checked_where_they_are_written() -> None:
    with pytest.raises(ValueError, match=r"control\.surge\.velocity_1_s\s+must be in \[0, 100\] 1/s"):
        VehicleModel.model_validate({**load_vehicle("rov").model_dump(), "control": {"surge": {"velocity_1_s": -1.0}}})
    undriven = load_vehicle("remus100").model_copy(
        update={"control": load_vehicle("rov").control.model_validate({"sway": {"position_1_s": 1.0}})}
    )
    with pytest.raises(ScenarioError, match=r"control\.sway: nothing drives the sway"):
        control_settings(undriven)
    with pytest.raises(ValueError, match="tracking_s"):
        Controller(deep_water(load_vehicle("rov")).rov, period_s=5.0)


def test_a_vehicle_without_settings_is_refused() -> None:
    class Remote:
        pose = velocity = None

        def set_effort(self, *efforts: float) -> None: ...

    with pytest.raises(ValueError, match="control_settings"):
        Controller(Remote())  # type: ignore[arg-type]
