"""tune: searches for gains of a vehicle's control loops by flying steps and gusts.

Differential evolution (Storn and Price 1997, SciPy's) finds one set of gains for surge, sway and heave and one for
roll, pitch and yaw. Over the steps of `uwsim validate control` and a minute in gusts, it minimises the time-weighted
error, the overshoot, the drift in gusts, and the changes of the efforts; the last term keeps the gains from growing
without bound. Gusts: 0.5 m/s mean, 0.2 m/s rms, 10 s correlation; the estimate has white noise of 0.02 m, 0.01 m/s,
0.01 rad and 0.005 rad/s. A vehicle without vertical thrust cannot hold a position, so that it flies no gusts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.optimize import differential_evolution
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.evidence.validate.step_responses import DURATION_S, PERIOD_S, StepResponse, step_responses
from uwsim.navigation.control import Controller
from uwsim.scenario import VehicleModel
from uwsim.scenario.spec.actuator import Control
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

GUSTS = {"kind": "gusts", "mean_m_s": (0.4, 0.3, 0.0), "sigma_m_s": (0.2, 0.2, 0.05), "correlation_time_s": 10.0}
NAMES = ("position_1_s", "velocity_1_s", "integral_1_s2")
BOUNDS = [(0.3, 3.0), (0.8, 8.0), (0.1, 8.0)] * 2
LINEAR = AXES[:3]
ROUGHNESS_COST, OVERSHOOT_COST, DRIFT_COST = 1.0, 4.0, 6.0
GUST_S, SETTLED_S = 60.0, 10.0


@dataclass(frozen=True, eq=False)
class Flown:
    """The flights with one set of gains.

    drift_m: rms distance from the position to hold in gusts; roughness: rms change of the efforts between periods; both
    None for a vehicle that flies no gusts. cost: the sum that is minimised.
    """

    responses: list[StepResponse]
    drift_m: float | None
    roughness: float | None
    cost: float


@dataclass(frozen=True, eq=False)
class Tuned:
    """The result of a search: the model with the best gains, which may be its own, and the flights before and after.

    left_out: the axes that nothing drives.
    """

    model: VehicleModel
    left_out: tuple[str, ...]
    before: Flown
    after: Flown


def tune(
    model: VehicleModel,
    *,
    generations: int = 12,
    population: int = 6,
    hear: Callable[[Floats], object] = lambda gains: None,
) -> Tuned:
    """Return the best gains found for a vehicle. The search begins with the means of the model's own gains, too.

    population: sets of gains in a generation, per gain. hear: called with the best gains of each generation. Raises
    ScenarioError if the vehicle cannot be built, ValueError if no step can be flown with its actuators.
    """
    driven = [axis for axis in AXES if axis in deep_water(model).rov.controllable]
    before = flown(model)
    found = differential_evolution(
        lambda gains: flown(with_gains(model, driven, gains)).cost,
        BOUNDS,
        maxiter=generations,
        popsize=population,
        rng=1,
        polish=False,
        x0=_own_gains(model, driven),
        callback=lambda gains, convergence: hear(gains),
    )
    tuned = with_gains(model, driven, found.x)
    after = flown(tuned)
    if after.cost >= before.cost:
        tuned, after = model, before
    return Tuned(tuned, tuple(axis for axis in AXES if axis not in driven), before, after)


def flown(model: VehicleModel) -> Flown:
    """Return the steps and the minute in gusts, flown with the model's gains."""
    responses = step_responses(model.name, model)
    if not responses:
        raise ValueError(f"vehicle '{model.name}': its actuators drive none of the steps that are flown to tune it")
    cost = 0.0
    for response in responses:
        error = np.abs(response.values - 1.0)
        cost += float((error * response.times_s).sum()) * PERIOD_S / DURATION_S + OVERSHOOT_COST * response.overshoot
    gusts = _in_gusts(model)
    if gusts is None:
        return Flown(responses, None, None, cost)
    drift_m, roughness = gusts
    cost += len(responses) * (DRIFT_COST * drift_m + ROUGHNESS_COST * roughness)
    return Flown(responses, drift_m, roughness, cost)


def with_gains(model: VehicleModel, driven: list[str], gains: Floats) -> VehicleModel:
    """Return the vehicle with three gains for its linear and three for its angular axes, on the driven axes only."""
    linear, angular = (dict(zip(NAMES, part.round(2).tolist(), strict=True)) for part in (gains[:3], gains[3:]))
    values = model.control.model_dump()
    loops = {axis: values[axis] | (linear if axis in LINEAR else angular) for axis in driven}
    limits = {key: value for key, value in values.items() if key not in AXES}
    return model.model_copy(update={"control": Control.model_validate(limits | loops)})


def control_text(tuned: Tuned) -> str:
    """Return the `control:` block in YAML: the gains of the driven axes, and the values that are not defaults."""
    values = tuned.model.control.model_dump(exclude_defaults=True)
    lines = ["control:"]
    for axis in (axis for axis in AXES if axis not in tuned.left_out):
        gains = {name: getattr(getattr(tuned.model.control, axis), name) for name in NAMES} | values.pop(axis, {})
        lines.append(f"  {axis}: {{{', '.join(f'{name}: {gain:g}' for name, gain in gains.items())}}}")
    return "\n".join([*lines, *(f"  {name}: {value:g}" for name, value in values.items())])


def _own_gains(model: VehicleModel, driven: list[str]) -> Floats:
    """Return the means of the model's gains over its driven axes, (6,), within BOUNDS."""
    parts = []
    for is_linear in (True, False):
        axes = [axis for axis in driven if (axis in LINEAR) is is_linear]
        loops = [getattr(model.control, axis) for axis in axes or [LINEAR[0] if is_linear else AXES[-1]]]
        parts += [float(np.mean([getattr(loop, name) for loop in loops])) for name in NAMES]
    low, high = np.transpose(BOUNDS)
    return np.clip(parts, low, high)


def _in_gusts(model: VehicleModel) -> tuple[float, float] | None:
    """Return drift and roughness, or None without vertical thrust."""
    calm = deep_water(model).scenario
    sim = Simulator(calm.model_validate({**dict(calm), "water": {"current": GUSTS}}))
    if not {"surge", "heave"} <= sim.rov.controllable:
        return None
    controller = Controller(sim.rov, PERIOD_S, estimate=_NoisyEstimate(sim.rov, np.random.default_rng(1)))
    away, efforts = [], []
    for _ in range(round(GUST_S / PERIOD_S)):
        controller.hold(START_M, 0.5)
        sim.advance(PERIOD_S)
        away.append(np.linalg.norm(sim.rov.pose.position_world_m - START_M))
        efforts.append(sim.rov.effort)
    late = np.square(away[round(SETTLED_S / PERIOD_S) :])
    return float(np.sqrt(np.mean(late))), float(np.sqrt(np.mean(np.square(np.diff(efforts, axis=0)))))


@dataclass
class _NoisyEstimate:
    """The truth with white noise on position, attitude and velocity."""

    vehicle: Vehicle
    random: np.random.Generator

    @property
    def pose(self) -> Any:
        matrix = self.vehicle.pose.world_from_body.copy()
        matrix[:3, :3] = matrix[:3, :3] @ Rotation.from_rotvec(self.random.normal(0, 0.01, 3)).as_matrix()
        matrix[:3, 3] += self.random.normal(0, 0.02, 3)
        return SimpleNamespace(world_from_body=matrix, position_world_m=matrix[:3, 3])

    @property
    def velocity(self) -> Any:
        velocity = self.vehicle.velocity
        return SimpleNamespace(
            linear_body_m_s=velocity.linear_body_m_s + self.random.normal(0, 0.01, 3),
            angular_body_rad_s=velocity.angular_body_rad_s + self.random.normal(0, 0.005, 3),
        )
