"""A boat tows a body on a cable, whose shape at a steady speed is known."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sites import lake
from uwsim import Simulator
from uwsim.navigation.control import Controller

GRAVITY_M_S2, WATER_KG_M3, SPEED_M_S = 9.80665, 1000.0, 1.5
LENGTH_M, DIAMETER_M, CABLE_KG_M, NORMAL, ALONG = 30.0, 0.006, 0.06, 1.2, 0.01
RADIUS_M, DRAG = 0.1, 0.1
"""The towed body's, which is held at its nose, so that it is in line with what pulls it."""


def critical_angle_rad(weight_n_m: float, drag_n_m: float) -> float:
    """Return the angle below the flow at which a cable's weight balances the drag across it (Pode 1951)."""
    return math.acos((-weight_n_m + math.sqrt(weight_n_m**2 + 4.0 * drag_n_m**2)) / (2.0 * drag_n_m))


def towed(net_n: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the boat's steady speed [m/s], and the way to the body from the boat's end and its pull there [N]."""
    volume_m3 = 4 / 3 * math.pi * RADIUS_M**3
    cable = {
        "anchor": {"to": "boat", "at_m": [-1.0, 0, -0.1]}, "length_m": LENGTH_M, "elements": 40,
        "mass_kg_m": CABLE_KG_M, "diameter_m": DIAMETER_M, "normal_drag": NORMAL, "tangential_drag": ALONG,
        "at_m": [RADIUS_M, 0, 0],
    }  # fmt: skip
    fish = {
        "shape": {"kind": "sphere", "name": "fish", "position_m": [-25, 0, -10], "radius_m": RADIUS_M},
        "mass_kg": WATER_KG_M3 * volume_m3 + net_n / GRAVITY_M_S2, "drag_coefficient": DRAG, "tether": cable,
    }  # fmt: skip
    sim = Simulator(lake("otter", water={"density_kg_m3": WATER_KG_M3}, objects=[fish]), seed=1)
    pilot = Controller(sim.rov, 0.1)
    for _ in range(700):
        pilot.steer(0.0, (SPEED_M_S, 0.0))
        sim.advance(0.1)
    now = sim.tethers["fish"].read()
    return sim.rov.velocity.linear_body_m_s[0], now.points_world_m[-1] - now.points_world_m[0], now.anchor_force_world_n


def loads(speed_m_s: float) -> tuple[float, float, float, float]:
    """Return the cable's weight in water, its drag across and along the flow [N/m], and the body's drag [N]."""
    pressure = 0.5 * WATER_KG_M3 * speed_m_s**2
    weight_n_m = GRAVITY_M_S2 * (CABLE_KG_M - WATER_KG_M3 * math.pi / 4 * DIAMETER_M**2)
    along_n_m = pressure * ALONG * math.pi * DIAMETER_M
    return weight_n_m, pressure * NORMAL * DIAMETER_M, along_n_m, pressure * DRAG * math.pi * RADIUS_M**2


def of_law(speed_m_s: float, net_n: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the same by the equations of a towed cable (Pode 1951), integrated from the body upward.

    The body's drag is that along each of its axes, as a cable's, so that its pull has a critical angle, too.
    """
    weight_n_m, across_n_m, along_n_m, drag_n = loads(speed_m_s)

    def slope(_: float, state: np.ndarray) -> list[float]:
        tension_n, angle = state[:2]
        turn = (weight_n_m * math.cos(angle) - across_n_m * math.sin(angle) ** 2) / tension_n
        pull = weight_n_m * math.sin(angle) + along_n_m * math.cos(angle) ** 2
        return [pull, turn, math.cos(angle), math.sin(angle)]

    below = critical_angle_rad(net_n, drag_n)
    start = [drag_n * math.cos(below) ** 2 + net_n * math.sin(below), below, 0.0, 0.0]
    tension_n, angle, ahead_m, up_m = solve_ivp(slope, (0.0, LENGTH_M), start, rtol=1e-9).y[:, -1]
    return np.array([-ahead_m, 0.0, -up_m]), tension_n * np.array([-math.cos(angle), 0.0, -math.sin(angle)])


@pytest.mark.parametrize("net_n", [3.0, 30.0])
def test_a_towed_body_is_as_deep_as_the_law_of_its_cable_has_it(net_n: float) -> None:
    speed_m_s, way_m, pull_n = towed(net_n)
    law_m, law_n = of_law(speed_m_s, net_n)
    assert speed_m_s == pytest.approx(SPEED_M_S, abs=0.02)
    assert way_m == pytest.approx(law_m, abs=0.005 * LENGTH_M)
    assert way_m[2] == pytest.approx(law_m[2], rel=0.01)
    assert pull_n == pytest.approx(law_n, abs=0.02 * np.linalg.norm(law_n))


def test_a_body_as_heavy_for_its_drag_as_its_cable_is_towed_on_a_straight_line() -> None:
    """It pulls at the cable's own critical angle, so that nothing bends the cable."""
    weight_n_m, across_n_m, _, drag_n = loads(SPEED_M_S)
    angle = critical_angle_rad(weight_n_m, across_n_m)
    speed_m_s, way_m, _ = towed(drag_n * weight_n_m / across_n_m)
    assert speed_m_s == pytest.approx(SPEED_M_S, rel=0.005)
    assert way_m == pytest.approx([-LENGTH_M * math.cos(angle), 0.0, -LENGTH_M * math.sin(angle)], abs=0.15)
