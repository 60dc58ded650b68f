"""Checks a task's class before it is used, and everything that its methods return.

Each error names the task's method, the member and the value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from inspect import isclass
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Space
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.base.named import did_you_mean
from uwsim.learning.arrays import require_shape, rows
from uwsim.learning.task import Field, Flags, Floats, Start, Task, Verdict

PERIODS = ("period_s", "duration_s")


def require_task(kind: Any) -> None:
    """Raise ValueError unless the argument is a complete Task class with valid attributes."""
    if not isclass(kind) or not issubclass(kind, Task):
        raise ValueError(f"task = {kind!r:.60}: must be a class derived from uwsim.learning.task.Task")
    name = kind.__name__
    if missing := sorted(getattr(kind, "__abstractmethods__", ())):
        raise ValueError(f"{name}: does not define {', '.join(missing)}")
    if missing := [key for key in ("scenario", "draws", "goal_fields") if not hasattr(kind, key)]:
        raise ValueError(f"{name}.{missing[0]}: is missing")
    for key in PERIODS:
        value = getattr(kind, key)
        if not (isinstance(value, int | float) and 0.0 < value < math.inf):
            raise ValueError(f"{name}.{key} = {value!r} s: must be a positive number")
    if not (isinstance(kind.draws, int) and kind.draws >= 0):
        raise ValueError(f"{name}.draws = {kind.draws!r}: must be a whole number, 0 or more")
    _require_axes(name, kind.axes)
    _require_joints(name, kind)
    _require_fields(name, kind.goal_fields)
    names = [field.name for field in kind.fields()]
    if twice := sorted({one for one in names if names.count(one) > 1}):
        raise ValueError(f"{name}.goal_fields: two fields have the name '{twice[0]}'")


def _require_axes(name: str, axes: Any) -> None:
    if isinstance(axes, str) or not isinstance(axes, Sequence) or not axes or len(set(axes)) < len(axes):
        raise ValueError(f"{name}.axes = {axes!r}: must be different names from {', '.join(AXES)}")
    for axis in axes:
        if axis not in AXES:
            rule = f"must be one of {', '.join(AXES)}{did_you_mean(str(axis), AXES)}"
            raise ValueError(f"{name}.axes: {axis!r}: {rule}")


def _require_joints(name: str, kind: type[Task]) -> None:
    joints: Any = kind.joints
    if not isinstance(joints, Mapping) or any(
        isinstance(each, str) or not isinstance(each, Sequence) or not each for each in joints.values()
    ):
        raise ValueError(f"{name}.joints = {joints!r:.60}: must be lists of joints by name")
    every = [joint for each in joints.values() for joint in each]
    if twice := sorted({joint for joint in every if every.count(joint) > 1}):
        raise ValueError(f"{name}.joints: {twice[0]!r}: must be in one list only")
    if twice := [one for one in joints if one in kind.axes]:
        raise ValueError(f"{name}.joints: '{twice[0]}': is the name of an axis")


def _require_fields(name: str, fields: Any) -> None:
    if not isinstance(fields, tuple) or not all(isinstance(field, Field) for field in fields):
        raise ValueError(f"{name}.goal_fields = {fields!r:.60}: must be a tuple of Field")


def checked_start(task: Task, start: Any, members: NDArray[np.intp]) -> Start:
    """Return the initial poses of members (m,) as float64. Raises ValueError."""
    where = f"{type(task).__name__}.start"
    if not isinstance(start, Start):
        raise ValueError(f"{where}: returned {type(start).__name__}: must return Start")
    position = rows(where, "position_world_m", start.position_world_m, (len(members), 3), members)
    return Start(position, rows(where, "yaw_rad", start.yaw_rad, (len(members),), members))


def checked_efforts(task: Task, efforts: Any) -> Floats:
    """Return efforts (n, 6) as float64. Raises ValueError unless all are in [-1, 1]."""
    where = f"{type(task).__name__}.efforts"
    values = rows(where, "efforts", efforts, (task.batch.n, len(AXES)))
    outside = np.abs(values) > 1.0
    if outside.any():
        member, axis = np.argwhere(outside)[0].tolist()
        raise ValueError(f"{where}: member {member}, {AXES[axis]} = {values[member, axis]:g}: must be in [-1, 1]")
    return values


def checked_verdict(task: Task, verdict: Any) -> Verdict:
    """Return the verdict with the reward as float64. Raises ValueError. Figures may be NaN."""
    where, n = f"{type(task).__name__}.judge", task.batch.n
    if not isinstance(verdict, Verdict):
        raise ValueError(f"{where}: returned {type(verdict).__name__}: must return Verdict")
    if not isinstance(verdict.figures, Mapping):
        raise ValueError(f"{where}: figures is {type(verdict.figures).__name__}: must be a mapping of arrays by name")
    figures = {}
    for name, values in verdict.figures.items():
        figures[name] = np.asarray(values)
        require_shape(where, f"figures[{name!r}]", figures[name], (n,))
        if figures[name].dtype.kind not in "fiub":
            raise ValueError(f"{where}: figures[{name!r}].dtype = {figures[name].dtype}: must be numbers or bool")
    return Verdict(rows(where, "reward", verdict.reward, (n,)), _flags(where, verdict.terminated, n), figures)


def _flags(where: str, values: Any, n: int) -> Flags:
    flags = np.asarray(values)
    require_shape(where, "terminated", flags, (n,))
    if flags.dtype != np.bool_:
        raise ValueError(f"{where}: terminated.dtype = {flags.dtype}: must be bool")
    return flags


def require_observed(task: Task, space: Space[Any], observation: Any, part: str = "") -> None:
    """Raise ValueError unless observations have the space's type and keys, and one row per member in its range."""
    where = f"{type(task).__name__}.observe"
    if isinstance(space, Dict):
        keys = sorted(observation) if isinstance(observation, dict) else type(observation).__name__
        if keys != sorted(space.spaces):
            raise ValueError(f"{where}: returned {keys}: must return a dict of {', '.join(sorted(space.spaces))}")
        for key, inner in space.spaces.items():
            require_observed(task, inner, observation[key], f"['{key}']")
        return
    if not isinstance(space, Box):
        return
    name = f"observation{part}"
    if not isinstance(observation, np.ndarray):
        raise ValueError(f"{where}: {name} is {type(observation).__name__}: must be an array")
    require_shape(where, name, observation, (task.batch.n, *space.shape))
    if observation.dtype != space.dtype:
        raise ValueError(f"{where}: {name}.dtype = {observation.dtype}: must be {space.dtype}")
    if space.dtype == np.uint8:
        return  # pictures, which use the whole range
    outside = ~((observation >= space.low) & (observation <= space.high))  # also true for NaN
    if outside.any():
        member, *at = np.argwhere(outside)[0].tolist()
        low, high = space.low[tuple(at)], space.high[tuple(at)]
        rule = f"must be in [{low:g}, {high:g}]"
        raise ValueError(f"{where}: member {member}, {name}{at} = {observation[(member, *at)]:g}: {rule}")
