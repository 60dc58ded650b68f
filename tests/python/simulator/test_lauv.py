"""The packaged LAUV against the equations of its source, DUNE's VSIM, which are written out here."""

import numpy as np
import pytest
from scipy.optimize import fsolve

from sites import lake
from uwsim import Simulator

MASS_KG, FIN, LEVER_M = 24.0, 9.64, 0.398


def flown(command: float, rudder_rad: float) -> tuple[float, float, float]:
    """Return the steady velocities ahead and to starboard [m/s] and the turning rate to starboard [rad/s]."""
    sim = Simulator(lake("lauv", (0, 0, -40), bed_m=-100), seed=1)
    sim.rov.set_thrusters({"propeller": command})
    sim.rov.set_fins({"top": -rudder_rad, "bottom": rudder_rad})
    sim.advance(60.0)
    linear, angular = sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s
    return float(linear[0]), float(-linear[1]), float(-angular[2])


def of_source(thrust_n: float, rudder_rad: float) -> tuple[float, float, float]:
    """Return the same by UUV.cpp and Object.cpp of VSIM and its model "lauv", in the horizontal plane.

    Not by its Fin.cpp: the force and the lever of the fins are those that its terms of lift contain.
    """

    def forces(motion: np.ndarray) -> tuple[float, float, float]:
        u, v, r = motion
        pushed = FIN * rudder_rad * u * u
        surge = thrust_n - 2.4 * u - 2.4 * u * abs(u) + (MASS_KG + 16) * v * r
        drag = -23 * v - 80 * v * abs(v) - 11.5 * r - 0.3 * r * abs(r)
        sway = drag - (MASS_KG + 1) * u * r + (-20.6 * v + 3.84 * r) * u + pushed
        turning = -9.7 * r - 9.1 * r * abs(r) + 3.1 * v + 1.5 * v * abs(v)
        yaw = turning - (16 - 1) * u * v + (6 * v - 1.53 * r) * u - LEVER_M * pushed
        return surge, sway, yaw

    u, v, r = fsolve(forces, (1.2, 0.0, -0.1))
    return float(u), float(v), float(r)


@pytest.mark.parametrize(("command", "speed_m_s"), [(0.36, 1.0), (0.46, 1.3)])
def test_it_is_as_fast_as_dune_converts_speeds(command: float, speed_m_s: float) -> None:
    assert flown(command, 0.0)[0] == pytest.approx(speed_m_s, rel=2e-3)


def test_its_terminal_speed_is_that_of_its_drag() -> None:
    """12 N = 2.4 u + 2.4 u^2."""
    assert flown(1.0, 0.0)[0] == pytest.approx(-0.5 + np.sqrt(0.25 + 12 / 2.4), rel=1e-3)


@pytest.mark.parametrize(
    ("command", "thrust_n", "rudder_rad"), [(0.36, 4.8, 0.2), (0.46, 7.18, 0.1), (0.46, 7.18, 0.3)]
)
def test_its_turning_radius_is_that_of_its_source(command: float, thrust_n: float, rudder_rad: float) -> None:
    u, v, r = flown(command, rudder_rad)
    source = of_source(thrust_n, rudder_rad)
    assert r < 0  # to port
    assert np.hypot(u, v) / abs(r) == pytest.approx(np.hypot(*source[:2]) / abs(source[2]), rel=0.01)
    assert (u, v, r) == pytest.approx(source, rel=0.02)
