"""Thrusters and fins proposed for a hull whose mass and drag are estimates."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.scenario.spec.actuator import load_thruster

SPEEDS_M_S = (1.5, 0.5, 0.5)
"""Speeds that the thrusters should reach ahead, sideways and vertically."""
ACCELERATION_M_S2 = 0.3
"""The acceleration from rest along each axis that the thrusters should reach."""
ARM = 0.15
"""Distance of the horizontal thrusters from the centre line, relative to the length, where the hull is narrower."""
CLEAR_M = 0.06
"""Room for a thruster beside the hull."""
FIN_ASPECT = 3.0
SPIN = ("clockwise", "counter-clockwise")


@dataclass(frozen=True, eq=False)
class Body:
    """Estimates of a hull, about its centroid, body frame.

    low_m, high_m: (3,) corners of its box. inertia_kg_m2: (3,). added: (6, 6). quadratic: (6,) drag. surge_spread: the
    drag ahead without and with separation. lever_m: depth of the centre of mass below the centroid.
    """

    low_m: Floats
    high_m: Floats
    mass_kg: float
    inertia_kg_m2: Floats
    added: Floats
    quadratic: Floats
    surge_spread: tuple[float, float]
    munk_share: float
    lever_m: float
    density_kg_m3: float

    @property
    def length_m(self) -> float:
        """The length of the hull along x."""
        return float(self.high_m[0] - self.low_m[0])

    @property
    def turn_rad_s(self) -> float:
        """A turn rate at which bow and stern move at 0.25 m/s; at most 0.5 rad/s."""
        return min(0.5, 0.5 / self.length_m)

    @property
    def turn_acceleration_rad_s2(self) -> float:
        """An acceleration that reaches that rate in half a second."""
        return 2.0 * self.turn_rad_s


@dataclass(frozen=True)
class Thrust:
    """A thruster. gain: a factor on the packaged T200's thrust."""

    name: str
    position_m: tuple[float, float, float]
    axis: tuple[float, float, float]
    spin: str
    gain: float


@dataclass(frozen=True)
class Fin:
    """A fixed tail fin."""

    name: str
    position_m: tuple[float, float, float]
    span: tuple[float, float, float]
    area_m2: float
    aspect_ratio: float


def proposed_thrusters(body: Body, axes: Collection[str]) -> tuple[Thrust, ...]:
    """Return thrusters that drive each of `axes`, strong enough for the body's accelerations and SPEEDS_M_S.

    Surge and yaw share a pair beside the stern, sway has one amidships; heave, roll and pitch share one, two or four
    vertical ones. All thrust lines pass the height of the centroid, where the drag acts.
    """
    needed = needed_wrench(body, axes)
    stern, side = 0.8 * float(body.low_m[0]), max(float(body.high_m[1]) + CLEAR_M, ARM * body.length_m)
    fore, beam = 0.35 * body.length_m, 0.35 * float(body.high_m[1] - body.low_m[1])
    places: list[tuple[str, tuple[float, float, float], int]] = []
    if "yaw" in axes:
        places += [("port", (stern, side, 0.0), 0), ("starboard", (stern, -side, 0.0), 0)]
    elif "surge" in axes:
        places += [("stern", (float(body.low_m[0]), 0.0, 0.0), 0)]
    if "sway" in axes:
        places += [("lateral", (0.0, 0.0, 0.0), 1)]
    xs = {"fore": fore, "aft": -fore} if "pitch" in axes else {"": 0.0}
    ys = {"port": beam, "starboard": -beam} if "roll" in axes else {"": 0.0}
    if {"heave", "roll", "pitch"} & set(axes):
        places += [("_".join(["vertical", *filter(None, (x, y))]), (xs[x], ys[y], 0.0), 2) for x in xs for y in ys]
    directions = np.array([np.eye(3)[along] for _, _, along in places])
    wrenches = np.hstack([directions, np.cross([at for _, at, _ in places], directions)])
    weakest_n = min(abs(thrust) for thrust in _ends_n())
    gains = [
        max(needed[k] / (np.abs(wrenches[:, k]).sum() * weakest_n) for k in range(6) if wrenches[j, k] and needed[k])
        for j in range(len(places))
    ]
    return tuple(
        Thrust(name, at, tuple(np.eye(3)[along]), SPIN[j % 2], float(np.clip(gains[j], 0.05, 100.0)))
        for j, (name, at, along) in enumerate(places)
    )


def _ends_n() -> tuple[float, float]:
    """Return the thrust of a T200 at full effort astern and ahead."""
    _, thrusts_n = load_thruster("t200_16v").curve_points
    return thrusts_n[0], thrusts_n[-1]


def needed_wrench(body: Body, axes: Collection[str]) -> Floats:
    """Return the forces and torques (6,) that drive `axes` at these speeds and accelerations; 0 on other axes."""
    speeds = np.array([*SPEEDS_M_S, *[body.turn_rad_s] * 3])
    accelerations = np.array([*[ACCELERATION_M_S2] * 3, *[body.turn_acceleration_rad_s2] * 3])
    inertia = np.array([*[body.mass_kg] * 3, *body.inertia_kg_m2]) + np.diagonal(body.added)
    needed = body.quadratic * speeds**2 + inertia * accelerations
    return np.where([axis in axes for axis in AXES], needed, 0.0)


def proposed_fins(body: Body) -> tuple[Fin, ...]:
    """Return a level and an upright fin at the stern whose lift cancels the Munk moment at any speed.

    The moment per angle and u^2 is munk_share times the difference of the added masses across and along (Newman 1977,
    "Marine Hydrodynamics", sec. 4.13); the fin's is 1/2 rho S arm C_La, with C_La = 2 pi A / (A + 2) of a slender wing.
    """
    arm_m = -float(body.low_m[0])
    slope = 2.0 * np.pi * FIN_ASPECT / (FIN_ASPECT + 2.0)
    fins = []
    for name, across, span in (("level", 2, (0.0, 1.0, 0.0)), ("upright", 1, (0.0, 0.0, 1.0))):
        munk_kg = body.munk_share * float(body.added[across, across] - body.added[0, 0])
        if munk_kg > 0.05 * body.mass_kg:
            area_m2 = munk_kg / (0.5 * body.density_kg_m3 * arm_m * slope)
            fins.append(Fin(name, (-arm_m, 0.0, 0.0), span, area_m2, FIN_ASPECT))
    return tuple(fins)
