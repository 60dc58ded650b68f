"""The packaged boat against the equations of its source, Fossen's otter.py, which are written out here."""

import numpy as np
import pytest
from scipy.optimize import fsolve

from sites import lake
from uwsim import Simulator

MASS_KG, CENTRE_M, ARM_M = 80.0, 0.153125, 0.395
ADDED = np.array([5.5, 82.5, 25.67])
DAMPING = np.array([77.55, 162.5, 42.65])


def steady(port: float, starboard: float) -> tuple[float, float, float]:
    """Return the velocities ahead and to port [m/s] and the turning rate to port [rad/s] after 80 s."""
    sim = Simulator(lake("otter"), seed=1)
    sim.rov.set_thrusters({"port": port, "starboard": starboard})
    sim.advance(80.0)
    linear, angular = sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s
    return float(linear[0]), float(linear[1]), float(angular[2])


def of_source(port: float, starboard: float, guess: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the same by otter.py in the horizontal plane, without the trim that its payload causes."""

    def thrust(share: float) -> float:
        n = share * np.sqrt(0.5 * 24.4 * 9.81 / 0.01108)
        return float((0.01108 if n > 0 else 0.006445) * n * abs(n))

    def forces(motion: np.ndarray) -> np.ndarray:
        u, v, r = motion
        x = np.linspace(-1.0, 1.0, 201)
        strip = -0.5 * 1026 * 0.19512 * 1.004 * np.abs(v + x * r) * (v + x * r)
        left, right = thrust(port), thrust(starboard)
        surge = left + right - DAMPING[0] * u + (MASS_KG + ADDED[1]) * v * r + MASS_KG * CENTRE_M * r * r
        sway = -DAMPING[1] * v + np.trapezoid(strip, x) - (MASS_KG + ADDED[0]) * u * r
        turn = (right - left) * ARM_M - DAMPING[2] * r - 10 * DAMPING[2] * abs(r) * r + np.trapezoid(x * strip, x)
        yaw = turn - MASS_KG * CENTRE_M * u * r - (ADDED[1] - ADDED[0]) * u * v
        return np.array([surge, sway, yaw])

    u, v, r = fsolve(forces, guess)
    return float(u), float(v), float(r)


@pytest.mark.parametrize(("port", "starboard"), [(0.8, 0.6), (-0.3, 0.6)])
def test_its_turning_circle_and_speed_are_those_of_its_source(port: float, starboard: float) -> None:
    """They differ as the propellers under water trim it by the stern, which the source leaves out."""
    u, v, r = steady(port, starboard)
    source = of_source(port, starboard, (u, v, r))
    assert r * (starboard - port) > 0
    assert np.hypot(u, v) == pytest.approx(np.hypot(*source[:2]), rel=0.015)
    assert np.hypot(u, v) / abs(r) == pytest.approx(np.hypot(*source[:2]) / abs(source[2]), rel=0.03)


def test_it_reaches_the_six_knots_for_which_its_drag_is_specified() -> None:
    """The source's surge damping is its full thrust over 6 knots; full ahead, it turns slowly, as the source does."""
    u, v, r = steady(1.0, 1.0)
    source = of_source(1.0, 1.0, (2.9, 0.3, -0.27))
    assert np.hypot(u, v) == pytest.approx(6 * 0.5144, rel=0.02)
    assert np.hypot(u, v) == pytest.approx(np.hypot(*source[:2]), rel=0.04)
    assert abs(r) == pytest.approx(abs(source[2]), rel=0.15)


@pytest.mark.parametrize(
    ("height_m", "share"),
    [(0.2, 1.0), (0.13, 1.0), (0.1, 0.893), (0.05, 0.633), (0.0, 0.325), (-0.048, 0.0), (-0.1, 0.0)],
)
def test_a_propeller_that_ventilates_keeps_the_published_share_of_its_thrust(height_m: float, share: float) -> None:
    """By depth of the hub, with a radius of 0.1 m."""
    mounts = {
        name: {
            "model": "otter_propeller", "position_m": [-0.7, y, -0.1], "axis": [1, 0, 0], "spin": spin,
            "ventilates": True,
        }
        for name, y, spin in (("port", 0.395, "clockwise"), ("starboard", -0.395, "counter-clockwise"))
    }  # fmt: skip
    model = {"builds_on": "otter", "thrusters": mounts}
    sim = Simulator(lake(model), seed=1)
    sim.rov.set_thrusters({"port": 0.5, "starboard": 0.5})
    sim.advance(3.0)
    thrust_n = []
    for hub_m in (1.0, height_m):
        sim.rov.place((0.0, 0.0, 0.1 - hub_m))
        sim.step(1)
        thrust_n.append(float(sim.rov.forces["actuators"].force_body_n[0]))
    assert thrust_n[1] / thrust_n[0] == pytest.approx(share, abs=0.004)


def test_it_floats_level_where_its_file_has_the_waterline() -> None:
    sim = Simulator(lake("otter"), seed=1)
    sim.advance(20.0)
    assert abs(sim.rov.pose.position_world_m[2]) < 0.002
    assert sim.rov.pose.world_from_body[2, 2] > np.cos(np.radians(0.1))
