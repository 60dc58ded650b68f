"""Simulated motions in deep, still water, for comparison with reference solutions."""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.motion.reference_solution import Flight
from uwsim.scenario import Scenario, VehicleModel
from uwsim.scenario.spec.vehicle import Trim
from uwsim.simulator.simulator import Simulator

ENGINE = ContextVar("engine", default="uwsim")
"""The `dynamics.engine` of the scenarios: the one under validation."""
START_M = (0.0, 0.0, -400.0)
BED_DEPTH_M = 1000.0
SAMPLE_S = 0.05


def deep_water(model: VehicleModel, *, density_kg_m3: float = 1000.0, step_s: float = 0.005) -> Simulator:
    """Return a simulator with a free vehicle in still water of uniform density, far from both surface and bed."""
    return Simulator(deep_scenario(model, density_kg_m3=density_kg_m3, step_s=step_s))


def deep_scenario(
    model: VehicleModel, *, density_kg_m3: float = 1000.0, step_s: float = 0.005, trim: Trim | None = None
) -> Scenario:
    """Return the scenario of deep_water. trim: replaces the model's."""
    return Scenario.model_validate({
        "name": "validation", "step_s": step_s, "dynamics": {"engine": ENGINE.get()},
        "water": {"density_kg_m3": density_kg_m3},
        "terrain": {"source": "noise", "size_m": [1000, 1000], "spacing_m": 100, "bed_depth_m": BED_DEPTH_M},
        "station": {"position_m": [0, 0, 0]},
        "vehicles": [{"name": "body", "model": model, "start": {"position_m": list(START_M)}, "trim": trim}],
    })  # fmt: skip


def times(duration_s: float) -> Floats:
    """Return the sample times from 0 to duration_s."""
    return np.linspace(0.0, duration_s, round(duration_s / SAMPLE_S) + 1)


def fly(sim: Simulator, velocity_body: Sequence[float] | Floats, duration_s: float) -> Flight:
    """Return the motion from START_M, starting level with velocity_body (6,), under the current efforts."""
    rov = sim.rov
    rov.place(START_M, velocity_body=np.asarray(velocity_body, np.float64))
    samples = times(duration_s)
    poses, velocities = [rov.pose], [rov.velocity]
    for _ in samples[1:]:
        sim.advance(SAMPLE_S)
        poses.append(rov.pose)
        velocities.append(rov.velocity)
    return Flight(
        samples,
        np.array([pose.position_world_m for pose in poses]) - START_M,
        np.array([pose.world_from_body[:3, :3] for pose in poses]),
        np.array([np.concatenate([v.linear_body_m_s, v.angular_body_rad_s]) for v in velocities]),
    )


def attitude_error_rad(got: Floats, expected: Floats) -> Floats:
    """Return the angles (n,) between attitudes (n, 3, 3)."""
    between = np.einsum("nji,njk->nik", expected, got)
    axis = np.stack([between[:, (k + 2) % 3, (k + 1) % 3] - between[:, (k + 1) % 3, (k + 2) % 3] for k in range(3)], -1)
    sine = 0.5 * np.linalg.norm(axis, axis=-1)
    cosine = 0.5 * (np.trace(between, axis1=1, axis2=2) - 1.0)
    return np.asarray(np.arctan2(sine, cosine), np.float64)
