"""Measures the wrench of a vehicle's actuators from the vehicle's motion.

Two simulators, one with and one without the actuators, take one step from the same state. The difference between their
velocities, multiplied by the published mass matrix, is the impulse of the actuators.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, along
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.evidence.validate.motion.published import PUBLISHED
from uwsim.evidence.validate.motion.published_thrusters import Propeller
from uwsim.evidence.validate.motion.reference_solution import resistance
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.spec.actuator import Control
from uwsim.simulator.simulator import Simulator

STEP_S = 0.0005
SETTLED = 16  # number of time constants after which the thrust is taken to have settled
LEVEL = (0.0, 0.0, 0.0, 1.0)
STILL = (0.0,) * 6
WRENCH_TOLERANCE = 1e-3


class Probe:
    """A vehicle with its actuators, and the same vehicle without them, both in deep water."""

    def __init__(self, name: str, model: VehicleModel | None = None) -> None:
        used = model or load_vehicle(name)
        without_actuators = {
            "max_force_n": (0.0,) * 3,
            "max_torque_nm": (0.0,) * 3,
            "thrusters": {},
            "fins": {},
            "control": Control(),
        }
        self.body = PUBLISHED[name]
        self._driven, self._bare = (self._simulator(m) for m in (used, used.model_copy(update=without_actuators)))
        self.rov = self._driven.rov

    def _simulator(self, model: VehicleModel) -> Simulator:
        return deep_water(model, density_kg_m3=self.body.water_density_kg_m3, step_s=STEP_S)

    def run(self, duration_s: float) -> None:
        """Place the vehicle at rest in deep water and let its actuators follow their commands."""
        self.rov.place(START_M)
        self._driven.advance(round(duration_s / STEP_S) * STEP_S)

    def command(self, commands: Mapping[str, float], propeller: Propeller) -> None:
        """Command thrusters and wait until their thrust has settled."""
        self.rov.set_thrusters(commands)
        self.run(SETTLED * propeller.time_constant_s)

    def wrench(
        self,
        velocity: Sequence[float] | Floats = STILL,
        at_m: Sequence[float] = START_M,
        attitude_xyzw: Sequence[float] = LEVEL,
    ) -> Floats:
        """Return the actuator wrench (6,): M x the acceleration difference + half of the resistance difference."""
        after = []
        for sim in (self._driven, self._bare):
            sim.rov.place(at_m, attitude_xyzw, velocity)
            sim.step()
            after.append(np.concatenate([sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s]))
        rate = self.body.mass @ (after[0] - after[1]) / STEP_S
        driven, bare = (resistance(self.body, nu, self.body.mass @ nu) for nu in after)
        return np.asarray(rate + 0.5 * (driven - bare))


def wrench_checks(group: str, name: str, expected: Floats, got: Floats) -> Iterator[Check]:
    """Compare forces and moments of wrenches (..., 6), each relative to its largest magnitude or, if larger, 0.1."""
    for what, part, unit in (("force", slice(0, 3), "N"), ("moment", slice(3, 6), "N m")):
        want, found = expected[..., part], got[..., part]
        scale = max(float(np.linalg.norm(want, axis=-1).max()), 0.1)
        yield along(group, f"{name}: {what}", want.ravel(), found.ravel(), scale, WRENCH_TOLERANCE, unit)
