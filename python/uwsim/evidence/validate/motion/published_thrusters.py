"""Propellers and mounts as printed in their sources, independent of the YAML files that the simulator reads.

The thrust law (Fossen 2011, Handbook, sec. 9.1) is repeated here independently of the core.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats


@dataclass(frozen=True)
class Propeller:
    """A propeller's parameters.

    table: (command, still-water thrust [N]). time_constant_s: lag of the thrust. bollard: K_T at rest.
    zero_thrust_advance: advance ratio J at which the thrust vanishes.
    """

    table: tuple[tuple[float, float], ...]
    time_constant_s: float
    diameter_m: float
    bollard: float
    zero_thrust_advance: float
    torque_per_thrust_m: float

    def thrust_n(self, still_n: float, inflow_m_s: float, density_kg_m3: float) -> float:
        """Return the thrust for an inflow along the axis, given the still-water thrust."""
        slope = self.diameter_m / self.zero_thrust_advance * np.sqrt(density_kg_m3 * self.bollard * abs(still_n))
        return float(still_n - slope * inflow_m_s)


# Blue Robotics, September 2019: (us, N) at 16 V. Lag: slowest pole of von Benzon et al. 2022. K_T: 51.5 N at 3533 rpm.
# Values chosen for uwsim, for the reasons given in the YAML file: zero-thrust J, torque.
T200_PWM_N = (
    (1100, -39.9), (1200, -26.6), (1300, -14.1), (1400, -4.71), (1472, 0.0),
    (1528, 0.0), (1600, 5.88), (1700, 17.85), (1800, 33.5), (1900, 51.5),
)  # fmt: skip
T200 = Propeller(tuple(((us - 1500) / 400, n) for us, n in T200_PWM_N), 0.076, 0.076, 0.445, 0.976, 0.0153)

# Fossen's remus100.py: (1 - t) rho D^4 K_T0 n|n| with t = 0.1, D = 0.14 m, K_T0 = 0.4566, 1525 rpm, T_n = 1 s; the
# inflow in the wake is 0.944 times the speed. K_T falls linearly, through 0.1798 at J = 0.6632, to zero at J = 1.0942.
# Torque per thrust: D K_Q0 / ((1 - t) K_T0) with K_Q0 = 0.07, rounded.
_REMUS_FULL_N = 0.9 * 1026 * 0.14**4 * 0.4566 * (1525 / 60) ** 2
REMUS_PROPELLER = Propeller(
    tuple((k / 10, _REMUS_FULL_N * k * abs(k) / 100) for k in range(-10, 11)),
    1.0, 0.14, 0.9 * 0.4566, 1.0942 / 0.944, 0.0238,
)  # fmt: skip


@dataclass(frozen=True)
class Mount:
    """A mounted propeller: position, thrust axis, and sense of rotation (1 right-handed, -1 left-handed)."""

    position_m: tuple[float, float, float]
    axis: tuple[float, float, float]
    spin: int
    propeller: Propeller = T200

    @property
    def unit(self) -> Floats:
        """The axis as a unit vector."""
        return np.asarray(self.axis, np.float64) / np.linalg.norm(self.axis)

    def wrench(self, thrust_n: float) -> Floats:
        """Return the wrench (6,): force, and moment about the origin including the propeller torque."""
        force = thrust_n * self.unit
        return np.concatenate(
            [force, np.cross(self.position_m, force) - self.spin * self.propeller.torque_per_thrust_m * force]
        )

    def inflow_m_s(self, velocity: Sequence[float] | Floats) -> float:
        """Return the hub's speed along the axis when the body moves with velocity (6,)."""
        return float(self.unit @ (np.asarray(velocity[:3]) + np.cross(velocity[3:], self.position_m)))


# Positions: von Benzon et al. 2022, table A1. Axes and spins: Blue Robotics' and ArduSub's "vectored" frames.
_VECTORED = {
    "front_left": Mount((0.14, 0.092, 0), (-1, 1, 0), -1),
    "front_right": Mount((0.14, -0.092, 0), (-1, -1, 0), -1),
    "rear_left": Mount((-0.15, 0.092, 0), (1, 1, 0), 1),
    "rear_right": Mount((-0.15, -0.092, 0), (1, -1, 0), 1),
}
_UP = (0.0, 0.0, 1.0)
# Positions of the two vertical thrusters: scaled from Blue Robotics' drawing.
_STANDARD = {
    **_VECTORED,
    "vertical_left": Mount((0, 0.111, 0.07), _UP, 1),
    "vertical_right": Mount((0, -0.111, 0.07), _UP, -1),
}
_HEAVY = {
    **_VECTORED,
    "vertical_front_left": Mount((0.118, 0.215, 0.064), _UP, 1),
    "vertical_front_right": Mount((0.118, -0.215, 0.064), _UP, -1),
    "vertical_rear_left": Mount((-0.118, 0.215, 0.064), _UP, -1),
    "vertical_rear_right": Mount((-0.118, -0.215, 0.064), _UP, 1),
}
MOUNTS: dict[str, dict[str, Mount]] = {
    "bluerov2_heavy": _HEAVY,
    "bluerov2_heavy_cfd": _HEAVY,
    "bluerov2_wu": _STANDARD,
    "bluerov2_tank": _STANDARD,
    "remus100": {"propeller": Mount((-0.8, 0, 0), (1, 0, 0), -1, REMUS_PROPELLER)},
}
