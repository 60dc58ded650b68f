"""Task: defines the start, observations, rewards and end of a batch's episodes."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Box, Space
from numpy.typing import NDArray

from uwsim.base.arrays import Floats as Floats
from uwsim.base.axes import AXES
from uwsim.base.short_repr import ShortRepr
from uwsim.batch import Batch
from uwsim.learning.arrays import rows
from uwsim.learning.motion import Motion
from uwsim.scenario import AnyScenario
from uwsim.scenario.read.assets import assets_folder

Flags = NDArray[np.bool_]
PACKAGED = assets_folder() / "learning"
"""The folder with the scenarios of the packaged tasks."""


@dataclass(frozen=True)
class Field:
    """A part of an observation: `width` values in the same unit, each within +-limit (or [low, limit]).

    usual: the usual size of each value, by which environments divide it; defaults to its limit. Raises ValueError.
    """

    name: str
    width: int
    limit: float
    unit: str
    about: str
    low: float | None = None
    usual: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check the field."""
        name = f"field '{self.name}'"
        if not isinstance(self.width, int) or self.width < 1:
            raise ValueError(f"{name}: width = {self.width!r}: must be a whole number, 1 or more")
        low = -self.limit if self.low is None else self.low
        if not -math.inf < low < self.limit < math.inf:
            raise ValueError(f"{name}: range {low:g} to {self.limit:g} {self.unit}: must be finite and ascending")
        if self.usual and len(self.usual) != self.width:
            raise ValueError(f"{name}: usual has {len(self.usual)} values: must have {self.width}, or none")
        if not all(0.0 < value < math.inf for value in self.usual):
            raise ValueError(f"{name}: usual = {self.usual}: must be positive and finite")

    @property
    def sizes(self) -> tuple[float, ...]:
        """The usual size of each value: (width,)."""
        return self.usual or (max(self.limit, -self.limit if self.low is None else -self.low),) * self.width


@dataclass(frozen=True, eq=False, repr=False)
class Start(ShortRepr):
    """Initial poses of m members, level and at rest: position_world_m (m, 3), yaw_rad (m,)."""

    position_world_m: Floats
    yaw_rad: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Verdict(ShortRepr):
    """The result of a step.

    reward: (n,). terminated: (n,), whether the task itself has ended. figures: (n,) by name, for `info`.
    """

    reward: Floats
    terminated: Flags
    figures: Mapping[str, NDArray[Any]]


class Task(ABC):
    """A kind of episode, for all members of a batch together: arrays have one row per member.

    scenario: a scenario, or the name or path of one, as for Simulator, or the values of one, with the keys of its YAML
    file. period_s: time between actions, a whole number of steps. duration_s: time after which an episode is truncated.
    axes: the efforts that an action sets, in [-1, 1]. joints: by the name of a further value of an action, in [-1, 1],
    the joints of the vehicle's arm whose speeds it sets, as shares of their motors' fastest. randomize: (low, high)
    ranges of the parameters drawn uniformly for each episode. draws: number of random values in [0, 1) that `start`
    needs per member. pings: whether the task uses the vehicle's first sonar. sensors: the sensors that the task reads;
    all other observed values are the true motion. goal_fields: what `goal` returns.

    A task may have additional arrays with a row per member; `start` resets the rows of the members that begin. All of
    its arrays, numbers and strings are part of an environment's saved state; other objects must not change.

    Everything that its methods return is checked: shapes, dtypes, finite values, ranges. Raises ValueError.
    """

    scenario: ClassVar[AnyScenario]
    period_s: ClassVar[float] = 0.05
    duration_s: ClassVar[float] = 20.0
    axes: ClassVar[tuple[str, ...]] = AXES
    joints: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    randomize: ClassVar[Mapping[str, tuple[float, float]]] = {}
    draws: ClassVar[int]
    pings: ClassVar[bool] = False
    sensors: ClassVar[tuple[str, ...]] = ()
    goal_fields: ClassVar[tuple[Field, ...]]

    def __init__(self, batch: Batch, vehicle: str | None = None) -> None:
        self.batch = batch
        self.vehicle = batch.scenario.vehicles[0].name if vehicle is None else vehicle
        self.columns = [AXES.index(axis) for axis in self.axes]

    def __repr__(self) -> str:
        return f"<{type(self).__name__} with {self.batch!r}>"

    @classmethod
    def fields(cls) -> tuple[Field, ...]:
        """Return the fields of an observation in order: those of the goal, then those of the vehicle."""
        return (
            *cls.goal_fields,
            Field(
                "up_body",
                3,
                1.0,
                "1",
                "the world's z axis in body axes, which shows the tilt",
                usual=(0.2, 0.2, 1.0),
            ),
            Field("linear_velocity_body", 3, 5.0, "m/s", "over ground, in body axes", usual=(0.2,) * 3),
            Field("angular_velocity_body", 3, 10.0, "rad/s", "in body axes", usual=(0.5,) * 3),
            Field(
                "effort",
                len(cls.action_names()),
                1.0,
                "1",
                "the previous action",
                usual=(0.5,) * len(cls.action_names()),
            ),
        )

    @classmethod
    def action_names(cls) -> tuple[str, ...]:
        """Return the names of an action's values: axes, then joints."""
        return (*cls.axes, *cls.joints)

    @property
    def observation_space(self) -> Space[Any]:
        """The Gymnasium space of a member's observations."""
        return box(self.fields())

    @property
    def action_space(self) -> Box:
        """The Gymnasium space of a member's actions: an effort for each of `axes`, a speed for each of `joints`."""
        return Box(-1.0, 1.0, (len(self.action_names()),), np.float32)

    def efforts(self, actions: Floats, now: Motion) -> Floats:
        """Return efforts (n, 6), surge to yaw, for actions (n, axes and joints)."""
        efforts = np.zeros((len(actions), len(AXES)))
        efforts[:, self.columns] = actions[:, : len(self.columns)]
        return efforts

    def observe(self, now: Motion, actions: Floats) -> Any:
        """Return observations, float32 (n, width), clipped to their limits.

        actions: (n, axes and joints), the previous actions.
        """
        width = sum(field.width for field in self.goal_fields)
        goal = rows(f"{type(self).__name__}.goal", "goal", self.goal(now), (len(actions), width))
        return observed(self.fields(), goal, now, actions)

    @abstractmethod
    def start(self, members: NDArray[np.intp], draws: Floats) -> Start:
        """Begin episodes for members (m,). draws: (m, self.draws), random values in [0, 1)."""

    @abstractmethod
    def goal(self, now: Motion) -> Floats:
        """Return the values of goal_fields, (n, their total width)."""

    @abstractmethod
    def judge(self, now: Motion, actions: Floats) -> Verdict:
        """Return the reward for the step just taken with these actions, and whether the task has ended.

        Also called when episodes begin, for all members; the verdict is then ignored, so do not count calls.
        """


def observed(fields: tuple[Field, ...], goal: Floats, now: Motion, actions: Floats) -> NDArray[np.float32]:
    """Return observations with these fields: the goal values, then the vehicle's motion."""
    return cut(np.concatenate((goal, now.up_body, now.velocity_body, actions), axis=1), fields)


def box(fields: tuple[Field, ...]) -> Box:
    """Return the Gymnasium space of observations with these fields."""
    low, high = limits(fields)
    return Box(low, high, dtype=np.float32)


def cut(values: Floats, fields: tuple[Field, ...]) -> NDArray[np.float32]:
    """Return observations (n, width), clipped to their limits."""
    return np.asarray(np.clip(values, *limits(fields), dtype=np.float32, casting="same_kind"))


_LIMITS: dict[tuple[Field, ...], tuple[NDArray[np.float32], NDArray[np.float32]]] = {}


def limits(fields: tuple[Field, ...]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the lowest and highest values in an observation, (width,) each."""
    if fields not in _LIMITS:
        low = [-field.limit if field.low is None else field.low for field in fields for _ in range(field.width)]
        high = [field.limit for field in fields for _ in range(field.width)]
        _LIMITS[fields] = np.array(low, np.float32), np.array(high, np.float32)
    return _LIMITS[fields]


def spread(draws: Floats, low: float, high: float) -> Floats:
    """Return draws in [0, 1) scaled to [low, high)."""
    return low + (high - low) * draws
