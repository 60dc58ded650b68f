"""A baseline for the task with a gripper: a policy written by hand, of observations in their own units."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwsim.learning.task import Floats, Task
from uwsim.learning.tasks.valve import GRIP_M, Valve

GAIN, DAMPING = 3.0, 1.5
"""Efforts per metre of error, and per m/s."""


def valve(observation: Any) -> Floats:
    """Return actions (n, 5) of Valve: align before the lever with closed jaws, and push it round, nose across it."""
    seen = _parts(Valve, observation)
    along = seen["lever_body"]
    across = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))])
    place = seen["spindle_body"] + GRIP_M * along
    aside, off = np.abs(np.einsum("ni,ni->n", place, along)), np.arctan2(across[:, 1], across[:, 0])
    is_aligned = (aside < 0.06) & (np.abs(place[:, 2]) < 0.03) & (np.abs(off) < 0.3)
    error = place + np.where(is_aligned, 0.05, -0.25)[:, None] * across
    return _towards(seen, error, off, np.ones(len(along)))


BASELINES = {"Valve": valve}


def _towards(seen: dict[str, Floats], error_m: Floats, turn_rad: Floats, grip: Floats) -> Floats:
    """Return actions: efforts against errors in body axes, (n, 3) and (n,), with damping, and the jaws' speed."""
    linear = GAIN * np.clip(error_m, -0.15, 0.15) - DAMPING * seen["linear_velocity_body"]
    yaw = 1.0 * np.clip(turn_rad, -0.5, 0.5) - 0.5 * seen["angular_velocity_body"][:, 2]
    return np.clip(np.column_stack([linear, yaw, grip]), -1.0, 1.0)


def _parts(kind: type[Task], observation: Any) -> dict[str, Floats]:
    """Return the fields of observations (n, width) by name, (n, width of the field) each."""
    values = np.atleast_2d(np.asarray(observation, np.float64))
    ends = np.cumsum([field.width for field in kind.fields()])
    return {field.name: part for field, part in zip(kind.fields(), np.split(values, ends[:-1], axis=1), strict=True)}
