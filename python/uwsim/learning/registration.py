"""Registers environments with Gymnasium: the packaged ones, and tasks of your own."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium
from gymnasium.envs import registration

if TYPE_CHECKING:
    from uwsim.learning.task import Task

NAMES = (
    "StationKeeping", "Waypoint", "PipelineFollowing", "Docking", "Coverage", "GatePassing", "TetheredReturn", "Valve",
)  # fmt: skip
ENVIRONMENTS = tuple(f"uwsim/{name}-v1" for name in NAMES)
"""Names of the current versions of all packaged environments in Gymnasium's registry."""


def register(name: str, task: type[Task], **options: Any) -> None:
    """Register a task of your own as the environment `name`, such as "lab/Hover-v0".

    gymnasium.make, gymnasium.make_vec and BatchVecEnv then accept the name. options: defaults for the options that
    these accept. Raises ValueError for an incomplete task, and gymnasium.error.Error for an invalid name.
    """
    from uwsim.learning.checks import require_task

    require_task(task)
    _register(name, task, options)


def register_packaged() -> None:
    """Register all packaged environments that are not yet registered.

    Version 1 observes values divided by their usual sizes, version 0 values in their own units.
    """
    for name in NAMES:
        for version, options in (("v0", {"normalise": False}), ("v1", {})):
            if f"uwsim/{name}-{version}" not in registration.registry:
                _register(f"uwsim/{name}-{version}", name, options)


def _register(name: str, task: str | type[Task], options: dict[str, Any]) -> None:
    registration.register(
        name,
        entry_point="uwsim.learning.registration:lone",
        vector_entry_point="uwsim.learning.registration:vector",
        kwargs={"task": task, **options},
    )


def lone(task: str | type[Task], **arguments: Any) -> gymnasium.Env[Any, Any]:
    """Return an environment for a task, or for the packaged task with this name."""
    from uwsim.learning.lone_env import LoneEnv

    return LoneEnv(_task(task), **arguments)


def vector(task: str | type[Task], num_envs: int = 1, **arguments: Any) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """Return a vector environment for a task, or for the packaged task with this name."""
    from uwsim.learning.vector_env import BatchEnv

    return BatchEnv(_task(task), num_envs, **arguments)


def _task(task: str | type[Task]) -> Any:
    return import_module("uwsim.learning.tasks").TASKS[task] if isinstance(task, str) else task
