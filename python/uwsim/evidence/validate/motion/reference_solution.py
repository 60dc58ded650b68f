"""Integrates the published equations of a rigid body in a fluid with SciPy, independently of the simulator.

The equations are Kirchhoff's in momentum form (Lamb 1932, Hydrodynamics, art. 124; Fossen 2011, ch. 6), in body axes at
the body's origin; P and L are the momenta of body and fluid together:

    P' = P x w + F        L' = L x w + P x v + T        (P, L) = (M_RB + M_A) (v, w)        R' = R [w]x

F and T are due to gravity at the centre of mass, buoyancy at the centre of buoyancy, linear and quadratic damping and a
constant wrench. In a separated flow, only a fraction (munk_share) of the Munk moment is left: in the products with P,
the added mass along each axis is reduced by (1 - munk_share) of its difference from the mean over the axes. Integrated
by DOP853 (Hairer, Norsett, Wanner 1993), relative tolerance 1e-12.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from uwsim.base.arrays import Floats

GRAVITY_M_S2 = 9.80665
TOLERANCE = 1e-12
SWAY, HEAVE, PITCH, YAW = 1, 2, 4, 5


@dataclass(frozen=True)
class Coefficients:
    """A vehicle's published coefficients. Six-vectors: surge, sway, heave, roll, pitch, yaw; body frame, REP 103."""

    mass_kg: float
    volume_m3: float
    inertia_kg_m2: tuple[float, ...]
    added_mass: tuple[float, ...]
    linear_damping: tuple[float, ...]
    quadratic_damping: tuple[float, ...]
    centre_of_mass_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    centre_of_buoyancy_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    munk_share: float = 1.0
    crossflow_length_m: float = 0.0
    water_density_kg_m3: float = 1000.0
    source: str = ""

    @property
    def rigid_mass(self) -> Floats:
        """M_RB (6, 6) about the origin."""
        across = cross_matrix(self.centre_of_mass_m)
        m = self.mass_kg
        inertia = np.diag(self.inertia_kg_m2) - m * across @ across
        return np.block([[m * np.eye(3), -m * across], [m * across, inertia]])

    @property
    def mass(self) -> Floats:
        """M_RB + M_A (6, 6)."""
        return self.rigid_mass + np.diag(self.added_mass)


@dataclass(frozen=True, eq=False)
class Flight:
    """A motion at times_s (n,): positions_m (n, 3), attitudes (n, 3, 3), world from body, and velocities (n, 6)."""

    times_s: Floats
    positions_m: Floats
    attitudes: Floats
    velocities: Floats


def cross_matrix(v: ArrayLike) -> Floats:
    """Return [v]x, the matrix for which [v]x u = v x u."""
    x, y, z = np.asarray(v, np.float64)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def integrate(
    body: Coefficients, velocity_body: ArrayLike, times_s: Floats, wrench_body: ArrayLike = (0.0,) * 6
) -> Flight:
    """Return the motion from the origin, starting level with velocity_body (6,), under a constant wrench (6,)."""
    mass, inverse = body.mass, np.linalg.inv(body.mass)
    applied = np.asarray(wrench_body, np.float64)
    weight_n = body.mass_kg * GRAVITY_M_S2
    lift_n = body.water_density_kg_m3 * body.volume_m3 * GRAVITY_M_S2
    at_mass, at_lift = np.asarray(body.centre_of_mass_m), np.asarray(body.centre_of_buoyancy_m)

    def rate(_: float, y: Floats) -> Floats:
        attitude, momentum = y[3:12].reshape(3, 3), y[12:]
        nu = inverse @ momentum
        up = attitude[2]
        wrench = applied - resistance(body, nu, momentum)
        wrench[:3] += (lift_n - weight_n) * up
        wrench[3:] += _cross(at_lift, lift_n * up) - _cross(at_mass, weight_n * up)
        return np.concatenate([attitude @ nu[:3], (attitude @ cross_matrix(nu[3:])).ravel(), wrench])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel(), mass @ np.asarray(velocity_body, np.float64)])
    solution = solve_ivp(
        rate, (0.0, float(times_s[-1])), start, method="DOP853", t_eval=times_s, rtol=TOLERANCE, atol=1e-13
    )
    y = solution.y.T
    return Flight(times_s, y[:, :3], y[:, 3:12].reshape(-1, 3, 3), y[:, 12:] @ inverse.T)


def resistance(body: Coefficients, nu: Floats, momentum: Floats) -> Floats:
    """Return the Coriolis, centripetal and damping terms, (6,), of nu and the momentum mass @ nu."""
    added = np.asarray(body.added_mass[:3])
    v, w = nu[:3], nu[3:]
    p, angular = momentum[:3] - (1.0 - body.munk_share) * (added - added.mean()) * v, momentum[3:]
    damping = (np.asarray(body.linear_damping) + np.asarray(body.quadratic_damping) * np.abs(nu)) * nu
    if body.crossflow_length_m > 0:
        damping -= crossflow_wrench(body, nu)
    return np.asarray(damping + np.concatenate([_cross(w, p), _cross(w, angular) + _cross(v, p)]))


def crossflow_wrench(body: Coefficients, nu: Floats) -> Floats:
    """Return the wrench (6,) that a hull's strips add to the drag of the separate axes, by piecewise Gauss quadrature.

    The strips cover crossflow_length_m, or less if their drag in turning would otherwise exceed the published drag.
    """
    wrench = np.zeros(6)
    for across, turn, sign in ((SWAY, YAW, 1.0), (HEAVE, PITCH, -1.0)):
        drag, turning = body.quadratic_damping[across], body.quadratic_damping[turn]
        half_m = min(body.crossflow_length_m / 2.0, np.cbrt(4.0 * turning / drag)) if drag else 0.0
        if half_m == 0.0:
            continue
        speed, rate = nu[across], sign * nu[turn]
        turns_at = -speed / rate if abs(rate) * half_m > abs(speed) else half_m
        for low, high in ((-half_m, turns_at), (turns_at, half_m)):
            x = 0.5 * (low + high) + 0.5 * (high - low) * np.array([-1.0, 1.0]) / np.sqrt(3.0)
            force = -drag / (2.0 * half_m) * 0.5 * (high - low) * (speed + rate * x) * np.abs(speed + rate * x)
            wrench[across] += force.sum()
            wrench[turn] += sign * (x * force).sum()
        wrench[across] += drag * speed * abs(speed)
        wrench[turn] += drag * half_m**3 / 4.0 * nu[turn] * abs(nu[turn])
    return wrench


def _cross(a: Floats, b: Floats) -> Floats:
    """Return the cross product of two vectors, much faster than np.cross, which handles arbitrary shapes."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
