"""The linear motion of a submerged vehicle about a straight course: its matrix, eigenvalues and modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.scenario.build.craft import craft, mass_properties
from uwsim.scenario.build.equipment import actuators_spec
from uwsim.scenario.spec.vehicle import Trim, VehicleModel

STATES = (*AXES, "roll angle", "pitch angle")
DEEP_M = 1000.0
STEP = 1e-6
STILL_1_S = 1e-4
"""Eigenvalues with smaller magnitudes are zero within the errors of the central differences: 2 h, and drag over h."""
SURGE = 0


@dataclass(frozen=True)
class Mode:
    """A mode of the linear motion: a real eigenvalue, or a conjugate pair with its positive imaginary part.

    growth_1_s: real part; negative if the mode decays. frequency_rad_s: imaginary part. moves: the axis with the
    largest participation factor (these do not depend on units).
    """

    growth_1_s: float
    frequency_rad_s: float
    moves: str

    @property
    def is_neutral(self) -> bool:
        """True if the mode neither grows nor decays, because its drag is quadratic or no moment restores it."""
        return abs(self.growth_1_s) < STILL_1_S

    @property
    def damping_ratio(self) -> float:
        """1 without oscillation, below 1 with it, negative if it grows."""
        size = float(np.hypot(self.growth_1_s, self.frequency_rad_s))
        return 0.0 if size == 0.0 else -self.growth_1_s / size


def model_motion(model: VehicleModel, trim: Trim | None, density_kg_m3: float, speed_m_s: float) -> Floats:
    """Return motion_matrix for a vehicle's file with a trim. Raises ScenarioError if it cannot be built."""
    return motion_matrix(craft(model, density_kg_m3, trim), actuators_spec(model).fins, speed_m_s, density_kg_m3)


def mass_matrix(model: VehicleModel, trim: Trim | None, density_kg_m3: float) -> Floats:
    """Return the mass of a vehicle and of the water that moves with it (6, 6), about its origin; Fossen 2021, ch. 3."""
    mass_kg, centre_m, inertia = mass_properties(model, density_kg_m3, trim)
    x, y, z = centre_m
    lever = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    own = np.block([[np.eye(3), -lever], [lever, -lever @ lever]]) * mass_kg
    own[3:, 3:] += inertia
    return np.asarray(own + model.matrix("added_mass"))


def motion_matrix(
    craft: _core.Craft, fins: list[_core.FinParameters], speed_m_s: float, density_kg_m3: float
) -> Floats:
    """Return the Jacobian (8, 8) of STATES' time derivatives, on a level course ahead at a speed in deep, still water.

    Computed by central differences of the simulator's own equations of motion. Propellers push as on the straight
    course; fins are amidships (fin_lift). Valid for small deviations: see Fossen 2021, "Handbook of Marine Craft
    Hydrodynamics and Motion Control", sec. 6.5.
    """
    water = _core.Water()
    water.density_kg_m3 = density_kg_m3

    def change(state: Floats) -> Floats:
        roll, pitch = 0.5 * state[6], 0.5 * state[7]
        turn = np.array([roll, pitch, 0.0, np.sqrt(1.0 - roll * roll - pitch * pitch)])
        body = _core.BodyState((0.0, 0.0, -DEEP_M), turn, state[:6])
        lift = sum((fin_lift(fin, state[:6], density_kg_m3) for fin in fins), np.zeros(6))
        return np.concatenate([craft.acceleration_body(body, lift, water), state[3:5]])

    course = np.eye(8)[SURGE] * speed_m_s
    return np.column_stack([(change(course + STEP * e) - change(course - STEP * e)) / (2.0 * STEP) for e in np.eye(8)])


def modes(matrix: Floats) -> tuple[Mode, ...]:
    """Return the modes of a motion matrix (8, 8), fastest growth first."""
    values, right = np.linalg.eig(matrix)
    left = np.linalg.pinv(right)
    found = []
    for value, vector, row in zip(values, right.T, left, strict=True):
        if value.imag >= 0.0:
            share = np.abs(vector * row)[:6] + np.concatenate([np.zeros(3), np.abs(vector * row)[6:], np.zeros(1)])
            found.append(Mode(float(value.real), float(value.imag), AXES[int(share.argmax())]))
    return tuple(sorted(found, key=lambda mode: -mode.growth_1_s))


def fin_lift(fin: _core.FinParameters, velocity: Floats, density_kg_m3: float) -> Floats:
    """Return the force and moment (6,) of a fin held amidships, in flow at a small angle to straight ahead.

    -1/2 rho U C_La A n (n . v); the slope is FinParameters.lift_slope.
    """
    at = np.asarray(fin.position_body_m)
    across = np.cross((1.0, 0.0, 0.0), np.asarray(fin.span_body))
    sideways_m_s = float(across @ (velocity[:3] + np.cross(velocity[3:], at)))
    force = -0.5 * density_kg_m3 * velocity[SURGE] * fin.lift_slope() * fin.area_m2 * sideways_m_s * across
    return np.concatenate([force, np.cross(at, force)])


def course_growth_1_s(matrix: Floats) -> float:
    """Return the largest growth rate of sway and yaw alone in a motion matrix (8, 8)."""
    pair = [AXES.index("sway"), AXES.index("yaw")]
    return float(np.linalg.eigvals(matrix[np.ix_(pair, pair)]).real.max())
