"""Tune the `control:` block of a vehicle's file: `python tools/tune_control.py bluerov2_heavy`; prints YAML.

Differential evolution (Storn and Price 1997, SciPy's) finds one set of gains for surge, sway and heave and one for
roll, pitch and yaw. Over the steps of `uwsim validate control` and a minute in gusts, it minimises the time-weighted
error, the overshoot, the drift in gusts, and the changes of the efforts; the last term keeps the gains from growing
without bound. Gusts: 0.5 m/s mean, 0.2 m/s rms, 10 s correlation; the estimate has white noise of 0.02 m, 0.01 m/s,
0.01 rad and 0.005 rad/s.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from scipy.optimize import differential_evolution

from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.evidence.validate.step_responses import DURATION_S, PERIOD_S, STEPS, step_responses
from uwsim.navigation.control import Controller
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.spec.control import Control
from uwsim.simulator.simulator import Simulator

GUSTS = {
    "kind": "gusts",
    "mean_m_s": (0.4, 0.3, 0.0),
    "sigma_m_s": (0.2, 0.2, 0.05),
    "correlation_time_s": 10.0,
}
NAMES = ("position_1_s", "velocity_1_s", "integral_1_s2")
BOUNDS = [(0.3, 3.0), (0.8, 8.0), (0.1, 8.0)] * 2
ROUGHNESS_COST, OVERSHOOT_COST, DRIFT_COST = 1.0, 4.0, 6.0
GUST_S = 60.0


@dataclass
class NoisyEstimate:
    """The truth with white noise on position, attitude and velocity."""

    vehicle: object
    random: np.random.Generator

    @property
    def pose(self) -> SimpleNamespace:
        """The vehicle's pose with noise."""
        from scipy.spatial.transform import Rotation

        pose = self.vehicle.pose
        matrix = pose.world_from_body.copy()
        matrix[:3, :3] = matrix[:3, :3] @ Rotation.from_rotvec(self.random.normal(0, 0.01, 3)).as_matrix()
        matrix[:3, 3] += self.random.normal(0, 0.02, 3)
        return SimpleNamespace(world_from_body=matrix, position_world_m=matrix[:3, 3])

    @property
    def velocity(self) -> SimpleNamespace:
        """The vehicle's velocity with noise."""
        velocity = self.vehicle.velocity
        return SimpleNamespace(
            linear_body_m_s=velocity.linear_body_m_s + self.random.normal(0, 0.01, 3),
            angular_body_rad_s=velocity.angular_body_rad_s + self.random.normal(0, 0.005, 3),
        )


def with_gains(model: VehicleModel, driven: list[str], gains: np.ndarray) -> VehicleModel:
    """Return the vehicle with three gains for its linear and three for its angular axes, on the driven axes only."""
    linear, angular = (dict(zip(NAMES, part.round(2).tolist(), strict=True)) for part in (gains[:3], gains[3:]))
    loops = {axis: linear if axis in ("surge", "sway", "heave") else angular for axis in driven}
    limits = {key: value for key, value in model.control.model_dump().items() if not isinstance(value, dict)}
    return model.model_copy(update={"control": Control.model_validate(limits | loops)})


def cost(gains: np.ndarray, model: VehicleModel, driven: list[str]) -> float:
    """Return the cost to minimise: a sum over the steps and the flight in gusts."""
    tuned = with_gains(model, driven, gains)
    total = 0.0
    for response in step_responses(model.name, tuned):
        error = np.abs(response.values - 1.0)
        total += float((error * response.times_s).sum()) * PERIOD_S / DURATION_S + OVERSHOOT_COST * response.overshoot
    drift_m, roughness = in_gusts(tuned)
    return total + len(STEPS) * (DRIFT_COST * drift_m + ROUGHNESS_COST * roughness)


def in_gusts(model: VehicleModel) -> tuple[float, float]:
    """Return the rms distance from the position to hold [m], and the rms change of the efforts between periods."""
    calm = deep_water(model).scenario
    gusty = calm.model_validate({**dict(calm), "water": {"current": GUSTS}})
    sim = Simulator(gusty)
    controller = Controller(sim.rov, PERIOD_S, estimate=NoisyEstimate(sim.rov, np.random.default_rng(1)))
    away, efforts = [], []
    for _ in range(round(GUST_S / PERIOD_S)):
        controller.hold(START_M, 0.5)
        sim.advance(PERIOD_S)
        away.append(np.linalg.norm(sim.rov.pose.position_world_m - START_M))
        efforts.append(sim.rov.effort)
    return float(np.sqrt(np.mean(np.square(away[200:])))), float(np.sqrt(np.mean(np.square(np.diff(efforts, axis=0)))))


def main() -> None:
    """Tune one vehicle and print its gains."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("vehicle")
    parser.add_argument("--generations", type=int, default=12)
    parser.add_argument("--population", type=int, default=6)
    arguments = parser.parse_args()
    model = load_vehicle(arguments.vehicle)
    controllable = deep_water(model).rov.controllable
    driven = [axis for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw") if axis in controllable]
    found = differential_evolution(
        cost,
        BOUNDS,
        args=(model, driven),
        maxiter=arguments.generations,
        popsize=arguments.population,
        rng=1,
        polish=False,
        callback=lambda x, convergence: print(f"# {np.round(x, 2).tolist()}", flush=True),
    )
    drift_m, roughness = in_gusts(with_gains(model, driven, found.x))
    print(f"# cost {found.fun:.3f}; in gusts {drift_m:.3f} m rms, efforts change by {roughness:.3f} rms a period")
    for axis in driven:
        gains = found.x[:3] if axis in ("surge", "sway", "heave") else found.x[3:]
        shown = ", ".join(f"{name}: {value:.2f}" for name, value in zip(NAMES, gains, strict=True))
        print(f"  {axis}: {{{shown}}}")


if __name__ == "__main__":
    main()
