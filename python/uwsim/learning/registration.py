"""Registers the environments with Gymnasium."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import gymnasium
from gymnasium.envs import registration

NAMES = ("StationKeeping", "Waypoint", "PipelineFollowing", "Docking", "Coverage", "GatePassing")
ENVIRONMENTS = tuple(f"uwsim/{name}-v0" for name in NAMES)
"""Names of all environments in Gymnasium's registry."""


def register() -> None:
    """Register all environments that are not yet registered."""
    for name, environment in zip(NAMES, ENVIRONMENTS, strict=True):
        if environment not in registration.registry:
            registration.register(
                environment,
                entry_point="uwsim.learning.registration:lone",
                vector_entry_point="uwsim.learning.registration:vector",
                kwargs={"task": name},
            )


def lone(task: str, **arguments: Any) -> gymnasium.Env[Any, Any]:
    """Return an environment for the task with this name."""
    from uwsim.learning.lone_env import LoneEnv

    return LoneEnv(_task(task), **arguments)


def vector(task: str, num_envs: int = 1, **arguments: Any) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """Return a vector environment for the task with this name."""
    from uwsim.learning.vector_env import BatchEnv

    return BatchEnv(_task(task), num_envs, **arguments)


def _task(name: str) -> Any:
    return import_module("uwsim.learning.tasks").TASKS[name]
