"""The control laws, each compared with its closed form."""

import math

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.navigation.control import Controller
from uwsim.scenario import ScenarioError, VehicleModel, control_settings, load_vehicle

PERIOD_S = 1e-3


def test_an_integrator_under_pi_control_answers_a_step_as_its_closed_form() -> None:
    """y' = u, u = K_p e + K_i int e with double pole w: e = (1 - w t) exp(-w t)."""
    w = 2.0
    gains = _core.PidGains(proportional=2 * w, integral=w * w)
    pid, y = _core.Pid(), 0.0
    for k in range(4000):
        t = k * PERIOD_S
        assert 1.0 - y == pytest.approx((1 - w * t) * math.exp(-w * t), abs=3e-3)
        u = pid.output(1.0 - y, y, gains, PERIOD_S)
        pid.settle(u, gains, PERIOD_S)
        y += u * PERIOD_S


def test_a_saturated_integral_follows_what_is_possible_with_its_tracking_time() -> None:
    """dI/dt = K_i e + (u_max - K_p e - I) / T_t: from 0 to its limit as 1 - exp(-t / T_t), in its sampled form."""
    gains = _core.PidGains(proportional=3.0, integral=4.0, tracking_s=0.5)
    error, most, period = 2.0, 1.0, 0.05
    limit = most - 3.0 * error + 0.5 * 4.0 * error
    pid = _core.Pid()
    for k in range(100):
        assert pid.integral == pytest.approx(limit * (1 - (1 - period / 0.5) ** k), abs=1e-12)
        pid.output(error, 0.0, gains, period)
        pid.settle(most, gains, period)
    # Once the error changes sign, the output leaves the limit immediately: there is no wind-up.
    assert pid.output(-0.01, 0.0, gains, period) < most + 4.0 * error * 0.5


def test_the_derivative_of_a_ramp_comes_with_its_filter_time() -> None:
    gains = _core.PidGains(proportional=0.0, derivative=2.0, filter_s=0.3)
    pid, period = _core.Pid(), 0.1
    for k in range(40):
        got = pid.output(0.0, 5.0 * period * k, gains, period)
        assert got == pytest.approx(-2.0 * 5.0 * (1 - (0.3 / 0.4) ** k), abs=1e-12)


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


def test_a_wrench_beyond_the_thrusters_keeps_its_torque_and_the_direction_of_its_force(heavy: Simulator) -> None:
    model = heavy.rov.control.model
    wanted = np.array([900.0, -500.0, 200.0, 1.0, -2.0, 3.0])
    got = model.reachable(wanted)
    assert got[3:] == pytest.approx(wanted[3:])
    share = got[0] / wanted[0]
    assert 0.01 < share < 0.5
    assert got[:3] == pytest.approx(share * wanted[:3])
    assert model.reachable(got) == pytest.approx(got)
    assert model.reachable(1.01 * got)[0] < 1.01 * got[0], "it is the largest"


@pytest.mark.parametrize("ahead_n", [900.0, -900.0])
def test_force_across_comes_before_force_along_if_wanted(heavy: Simulator, ahead_n: float) -> None:
    model = heavy.rov.control.model
    wanted = np.array([ahead_n, -60.0, 10.0, 0.5, -1.0, 2.0])
    got = model.reachable(wanted, across_first=True)
    assert got[1:] == pytest.approx(wanted[1:])
    assert abs(got[1]) > abs(model.reachable(wanted)[1])
    assert 0.05 < got[0] / ahead_n < 0.2
    more = got + 0.01 * ahead_n * np.eye(6)[0]
    assert model.reachable(more)[1] != pytest.approx(more[1]), "it is the largest"
    within = np.array([20.0, -10.0, 5.0, 0.0, 0.0, 0.0])
    assert model.reachable(within, across_first=True) == pytest.approx(within)


def test_the_fed_forward_wrench_gives_the_wanted_acceleration(heavy: Simulator) -> None:
    model, body = load_vehicle("bluerov2_heavy"), heavy.rov.control.model
    from scipy.spatial.transform import Rotation

    from uwsim.scenario.build.craft import craft

    turned = Rotation.from_euler("zyx", [0.7, -0.2, 0.1])
    velocity, wanted = np.array([0.8, -0.3, 0.2, 0.1, -0.2, 0.4]), np.array([0.3, -0.1, 0.2, 0.5, -0.4, 0.3])
    wrench = body.wrench_body(turned.as_matrix(), velocity, wanted)
    state = _core.BodyState([0, 0, -50.0], turned.as_quat(), velocity)
    assert craft(model, 1000.0).acceleration_body(state, wrench, _core.Water()) == pytest.approx(wanted, abs=1e-9)


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
