"""Checks the packaged vehicles against their published equations: speed decay, turning, free fall, terminal speed.

Every printed coefficient affects a check by more than its tolerance: changing any of them by 5 % makes a check fail.
Forces along the body axes replace thrusters and fins, whose own laws are not in these equations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.evidence.validate.check import Check, along, relative
from uwsim.evidence.validate.flights import deep_water, fly, times
from uwsim.evidence.validate.motion.published import PUBLISHED
from uwsim.evidence.validate.motion.reference_solution import GRAVITY_M_S2, Coefficients, Flight, integrate
from uwsim.scenario import VehicleModel
from uwsim.scenario.spec.actuator import Control

STILL = (0.0,) * 6
UNITS = ("m/s",) * 3 + ("rad/s",) * 3
FAST = (1.0, 0.7, 0.5, 1.0, 1.0, 1.0)
SLOWEST, SLOW = 0.01, 0.3  # limits of the slow initial speeds, at which linear damping matters
DECAY_S, FALL_S, TURN_S = 6.0, 60.0, 40.0
PUSH_M_S2, PUSH_S = 0.01, 0.05  # so weak and short that drag is less than 1e-4 of the force
DECAY_TOLERANCE, TURN_TOLERANCE, TERMINAL_TOLERANCE, MASS_TOLERANCE = 1e-4, 1e-4, 1e-3, 2e-3


@dataclass(frozen=True, eq=False)
class Manoeuvre:
    """A manoeuvre as simulated and according to the published equations."""

    vehicle: str
    name: str
    flown: Flight
    published: Flight


def vehicle_checks(name: str, model: VehicleModel) -> Iterator[Check]:
    """Yield the checks of a model against a vehicle's published values one by one."""
    body = PUBLISHED[name]
    yield _mass_check(name, model)
    sim = deep_water(_with_body_forces(model, STILL), density_kg_m3=body.water_density_kg_m3)
    for what, start in decay_speeds(body):
        yield _decay_check(
            Manoeuvre(name, what, fly(sim, start, DECAY_S), _published(name, tuple(start), DECAY_S, STILL))
        )
    fall = Manoeuvre(name, "free fall", fly(sim, STILL, FALL_S), _published(name, STILL, FALL_S, STILL))
    yield _decay_check(fall)
    yield from _terminal_check(fall)
    yield from _turning_checks(name, model)


def decay_speeds(body: Coefficients) -> list[tuple[str, Floats]]:
    """Return initial velocities along each axis: fast, and slow enough that linear and quadratic damping are equal."""
    starts = []
    for axis, name in enumerate(AXES):
        linear, quadratic = body.linear_damping[axis], body.quadratic_damping[axis]
        starts.append((f"decay of {name}", FAST[axis] * np.eye(6)[axis]))
        if linear > 0:
            slow = min(max(linear / quadratic if quadratic else SLOW, SLOWEST), SLOW)
            starts.append((f"slow decay of {name}", slow * np.eye(6)[axis]))
    return starts


@lru_cache(maxsize=128)
def _published(name: str, start: tuple[float, ...], duration_s: float, wrench: tuple[float, ...]) -> Flight:
    return integrate(PUBLISHED[name], start, times(duration_s), wrench)


def _decay_check(curve: Manoeuvre) -> Check:
    """Compare the largest error in the six velocities, relative to the reference's largest linear or angular speed."""
    expected, got = curve.published.velocities, curve.flown.velocities
    linear = max(float(np.abs(expected[:, :3]).max()), 1e-6)
    angular = max(float(np.abs(expected[:, 3:]).max()), 1e-6)
    axis = _leading_axis(curve, np.array([linear] * 3 + [angular] * 3))
    scale = linear if axis < 3 else angular
    name = f"{curve.name}: {AXES[axis]}"
    return along(
        curve.vehicle, name, expected[:, axis], got[:, axis], scale, DECAY_TOLERANCE, UNITS[axis],
        x=curve.flown.times_s,
    )  # fmt: skip


def _leading_axis(curve: Manoeuvre, scales: Floats) -> int:
    """Return the axis with the largest scaled error among those along which the manoeuvre moves."""
    distance = np.abs(curve.flown.velocities - curve.published.velocities).max(axis=0) / scales
    moves = np.abs(curve.published.velocities).max(axis=0) > 1e-5
    return int(np.argmax(np.where(moves, distance, -1.0)))


def _with_body_forces(model: VehicleModel, wrench: tuple[float, ...]) -> VehicleModel:
    """Return the vehicle with forces and torques along its body axes in place of thrusters and fins."""
    forces = {"max_force_n": wrench[:3], "max_torque_nm": wrench[3:]}
    return model.model_copy(update={**forces, "thrusters": {}, "fins": {}, "control": Control()})


def _mass_check(name: str, model: VehicleModel) -> Check:
    """Compare the mass: a known force divided by the resulting acceleration, minus the published added mass.

    A centre of mass below the line of force makes the body pitch and appear slightly lighter. A vehicle trimmed to
    neutral has no mass in its file; the mass follows from its volume and the water density.
    """
    body = PUBLISHED[name]
    force_n = PUSH_M_S2 * (body.mass_kg + body.added_mass[0])
    pushed = _with_body_forces(model, (force_n, *STILL[1:]))
    sim = deep_water(pushed, density_kg_m3=body.water_density_kg_m3)
    sim.rov.set_effort(surge=1.0)
    reached = fly(sim, STILL, PUSH_S).velocities[-1, 0]
    slowed_n = 0.5 * body.linear_damping[0] * reached  # mean over the push
    moved_kg = (force_n - slowed_n) * PUSH_S / reached
    pitched_kg = body.mass[0, 4] ** 2 / body.mass[4, 4]
    mass_kg = float(moved_kg + pitched_kg - body.added_mass[0])
    return relative(name, "mass", body.mass_kg, mass_kg, MASS_TOLERANCE, "kg")


def _turning_checks(name: str, model: VehicleModel) -> Iterator[Check]:
    """Compare the path from rest under constant surge force and yaw torque, relative to its diameter."""
    body = PUBLISHED[name]
    wrench = (_steady_wrench(body, 0, 0.8), 0.0, 0.0, 0.0, 0.0, _steady_wrench(body, 5, 0.3))
    sim = deep_water(_with_body_forces(model, wrench), density_kg_m3=body.water_density_kg_m3)
    sim.rov.set_effort(surge=1.0, yaw=1.0)
    flown, published = fly(sim, STILL, TURN_S), _published(name, STILL, TURN_S, wrench)
    diameter = float(np.ptp(published.positions_m[:, :2], axis=0).max())
    for k, axis in enumerate("xy"):
        expected, got = published.positions_m[:, k], flown.positions_m[:, k]
        yield along(name, f"turning circle: {axis}", expected, got, diameter, TURN_TOLERANCE, "m", x=published.times_s)


def _terminal_check(fall: Manoeuvre) -> list[Check]:
    """Compare the terminal speed, where damping equals the weight in water; no check for a neutral vehicle."""
    body = PUBLISHED[fall.vehicle]
    weight_n = (body.mass_kg - body.water_density_kg_m3 * body.volume_m3) * GRAVITY_M_S2
    if abs(weight_n) < 1e-3:
        return []
    linear, quadratic = body.linear_damping[2], body.quadratic_damping[2]
    speed = (np.sqrt(linear**2 + 4 * quadratic * abs(weight_n)) - linear) / (2 * quadratic)
    reached = float(fall.flown.velocities[-1, 2])
    return [relative(fall.vehicle, "terminal speed", -np.sign(weight_n) * speed, reached, TERMINAL_TOLERANCE, "m/s")]


def _steady_wrench(body: Coefficients, axis: int, speed: float) -> float:
    return body.linear_damping[axis] * speed + body.quadratic_damping[axis] * speed * abs(speed)
