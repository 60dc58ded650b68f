"""The packaged glider against the closed form of steady glides, and against the package gliderflight."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

import uwsim
from sites import lake
from uwsim import Simulator
from uwsim.examples import m14_glider
from uwsim.missions import OwnVehicle, Steps

PUMP_N, LIFT, DRAG_0, DRAG_2 = 2.514, 300.0, 8.65, 56.6  # the full pump; K_L, K_D0 and K_D of the vehicle's file


def deep(model: object = "slocum") -> Simulator:
    return Simulator(lake(model, (0, 0, -450), size_m=4000, bed_m=-900, mission_time_s=6000), seed=1)


@cache
def glide(pump: float, battery: float) -> tuple[float, float, float]:
    """Return the speed [m/s], the path's slope and the pitch [rad, positive upward] of a steady glide."""
    sim = deep()
    sim.rov.set_thrusters({"pump": pump, "battery": battery})
    sim.advance(300.0)
    turn = sim.rov.pose.world_from_body[:3, :3]
    moving = turn @ sim.rov.velocity.linear_body_m_s
    speed = float(np.linalg.norm(moving))
    return speed, math.asin(moving[2] / speed), math.asin(turn[2, 0])


def closed_form(force_n: float, slope_rad: float) -> tuple[float, float]:
    """Return speed and angle of attack: lift, drag and net weight in balance (Graver 2005, sec. 4.1), for sinking.

    As in the simulator, DRAG_0 acts along the hull, not along the path.
    """
    slope = abs(slope_rad)

    def drag(attack: float) -> float:
        return DRAG_0 * math.cos(attack) ** 3 + DRAG_2 * attack**2

    def off_balance(attack: float) -> float:
        lift = LIFT * attack - DRAG_0 * math.cos(attack) ** 2 * math.sin(attack)
        return lift * math.sin(slope) - drag(attack) * math.cos(slope)

    attack = float(brentq(off_balance, 0.0, 0.2))
    return math.sqrt(force_n * math.sin(slope) / drag(attack)), attack


GLIDES = pytest.mark.parametrize(("pump", "battery"), [(-1, 0), (-1, -0.5), (1, 0.5), (-0.3, 0)])


@GLIDES
def test_its_speed_and_angle_of_attack_are_those_of_the_closed_form(pump: float, battery: float) -> None:
    speed, slope, pitch = glide(pump, battery)
    assert math.copysign(1.0, slope) == math.copysign(1.0, pump)
    expected, attack = closed_form(PUMP_N * abs(pump), slope)
    assert speed == pytest.approx(expected, rel=0.006)
    assert abs(slope) - abs(pitch) == pytest.approx(attack, abs=math.radians(0.15))


@GLIDES
def test_gliderflight_has_the_same_speed_at_the_same_pitch(pump: float, battery: float) -> None:
    gliderflight = pytest.importorskip("gliderflight", reason="needs `pip install gliderflight`, a judge")
    speed, slope, pitch = glide(pump, battery)
    pressure = 0.5 * 1025.0
    model = gliderflight.gliderflight.SteadyStateGliderModel(rho0=1025.0)
    half = 0.5 * LIFT / pressure
    model.define(S=1.0, aw=half, ah=half, Cd0=DRAG_0 / pressure, Cd1=DRAG_2 / pressure)
    attack, theirs = model.solve_model(1025.0, PUMP_N * pump, np.array([pitch]), 0.0)
    assert speed == pytest.approx(theirs[0], rel=0.02)
    assert slope - pitch == pytest.approx(attack[0], abs=math.radians(0.1))


def test_dives_cost_the_net_buoyancy_times_the_slope_for_each_metre() -> None:
    """A dive of height h below z covers 2 h / tan(slope), for 2 F times the depth at which the pump works."""
    heights_m: list[float] = []

    def watched(vehicle: OwnVehicle) -> Steps[tuple[float, float]]:
        steps = m14_glider.mission(vehicle)
        while True:
            try:
                pause = next(steps)
            except StopIteration as end:
                return end.value
            heights_m.append(float(vehicle.pose.position_world_m[2]))
            yield pause

    ground_m, work_j = uwsim.fly(watched, "shelf").result
    slope = np.mean([math.tan(abs(glide(sign, sign * m14_glider.BATTERY)[1])) for sign in (-1.0, 1.0)])
    pumped_m, height_m = work_j / (2 * PUMP_N * m14_glider.DIVES), np.ptp(heights_m)
    assert work_j / ground_m == pytest.approx(PUMP_N * slope * pumped_m / height_m, rel=0.04)


def test_a_moved_mass_pitches_it_and_adds_no_force() -> None:
    sim = deep()
    sim.rov.set_thrusters({"battery": 1.0})
    sim.advance(60.0)
    lever = np.asarray(sim.rov.forces["actuators"].force_body_n)
    assert np.allclose(lever, 0.0, atol=1e-3)  # [N] of the wings: a moved mass adds none
    assert sim.rov.pose.world_from_body[2, 0] > 0.5  # bow up


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"axis": [1, 0, 0]}, "must be \\[0, 0, 1\\] for `force: weight`"),
        ({"moved_from_m": None}, "must be given for `force: weight`, and for no other"),
    ],
)
def test_what_its_file_gets_wrong_is_refused(change: dict, rule: str) -> None:
    battery = {
        "model": "slocum_battery", "position_m": [0.5, 0, 0], "moved_from_m": [-0.5, 0, 0], "axis": [0, 0, 1],
        "force": "weight",
    }  # fmt: skip
    model = {"builds_on": "slocum", "thrusters": {"battery": battery | change}}
    with pytest.raises(ValueError, match=rule):
        deep(model)
