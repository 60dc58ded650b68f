"""Actions of an arm: joints follow a trajectory, as joint_trajectory_controller of ros2_control serves it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from uwsim.bridges.actions.action import Offered
from uwsim.channels.authority.joint_motion import (
    GOAL_TIME_S,
    JointMotion,
    Limits,
    Outcome,
    Point,
    Tolerances,
    trajectory_of,
)
from uwsim.channels.authority.steering import require_link
from uwsim.channels.ros import build
from uwsim.channels.ros.action_types import FOLLOW_JOINTS
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator

FEEDBACK_S = 0.05
POINT = "trajectory_msgs/msg/JointTrajectoryPoint"
ERASED = -1.0  # control_msgs/msg/JointTolerance: any error is allowed


@dataclass(frozen=True, eq=False)
class JointAction(Offered):
    """The action FollowJointTrajectory of an arm. limits: of the joints with motors, by name."""

    limits: Mapping[str, Limits]


class JointGoal:
    """An accepted goal, with the methods of Goal.

    fed, ended: as Goal's, on the simulator's thread. Raises ValueError if the goal is impossible or the vehicle cannot
    be commanded now.
    """

    def __init__(
        self,
        live: LiveSimulator,
        action: JointAction,
        goal: Any,
        fed: Callable[[Any], object],
        ended: Callable[[bool, bool, Any], object],
    ) -> None:
        """ended: called with True for a success, True for a goal that was cancelled, and the result."""
        action.steering.rights.require(action.name)
        require_link(live, action.source.name, action.name)
        if action.source.of(live.simulator).all_stopped:
            raise ValueError(f"vehicle '{action.source.name}': all stop is set")
        if goal.multi_dof_trajectory.joint_names:
            raise ValueError("multi_dof_trajectory: must be empty: each joint has one degree of freedom")
        trajectory = trajectory_of(goal.trajectory, action.source, action.limits)
        if trajectory.start_ns > 0 and live.time_ns > trajectory.start_ns + 1e9 * trajectory.times_s[-1]:
            raise ValueError("trajectory: it has ended by now, by its header's stamp")
        self._action, self._live, self._fed, self._done = action, live, fed, ended
        self._names, self._fed_s = trajectory.names, -math.inf
        self._motion = JointMotion(
            live, action.source, trajectory, partial(action.steering.ask, live, "set_joints"),
            _tolerances(goal, action.source, trajectory.names), self._feed_back, self._end,
        )  # fmt: skip

    def start(self) -> None:
        """Begin to move, which replaces any earlier command of the joints."""
        self._action.steering.move_joints(self._motion)

    def cancel(self) -> None:
        """End the motion; the joints stop where they are."""
        self._motion.end("cancelled", is_cancelled=True)

    def close(self) -> None:
        """End the motion because the server is stopping."""
        self._motion.end("the server stops")

    def _feed_back(self, elapsed_s: float, wanted: Point, actual: Point) -> None:
        if elapsed_s - self._fed_s < FEEDBACK_S:
            return
        self._fed_s = elapsed_s
        error = Point(wanted.positions - actual.positions, wanted.speeds - actual.speeds)
        points = {
            name: build.message(
                POINT, positions=one.positions, velocities=one.speeds, time_from_start=build.duration(elapsed_s)
            )
            for name, one in (("desired", wanted), ("actual", actual), ("error", error))
        }
        self._fed(
            build.message(
                f"{FOLLOW_JOINTS}_Feedback",
                header=build.header(self._live.time_ns, ""),
                joint_names=[self._action.source.topic(name) for name in self._names],
                **points,
            )
        )

    def _end(self, outcome: Outcome) -> None:
        code = outcome.code if outcome.why else 0
        result = build.message(f"{FOLLOW_JOINTS}_Result", error_code=code, error_string=outcome.why)
        self._done(not outcome.why, outcome.is_cancelled, result)


def _tolerances(goal: Any, source: Source, names: Sequence[str]) -> Tolerances:
    """Return a goal's tolerances, by JointTolerance's rules: 0 for the usual one, -1 for none. Raises ValueError."""
    if len(goal.component_path_tolerance) or len(goal.component_goal_tolerance):
        raise ValueError("component_path_tolerance: must be empty: each joint has one degree of freedom")
    usual = Tolerances.usual(len(names))
    path, reached, speeds = usual.path.copy(), usual.goal.copy(), usual.speeds.copy()
    for field, each in (("path_tolerance", goal.path_tolerance), ("goal_tolerance", goal.goal_tolerance)):
        for one in each:
            name = {source.topic(own): own for own in names}.get(one.name, one.name)
            if name not in names:
                raise ValueError(f"{field}: {one.name}: must be one of {', '.join(names)}")
            k, at_end = names.index(name), field == "goal_tolerance"
            values = {"position": (reached if at_end else path, one.position)}
            if at_end:
                values["velocity"] = speeds, one.velocity
            for what, (array, value) in values.items():
                if value != ERASED and not (value >= 0.0 and math.isfinite(value)):
                    raise ValueError(f"{field}: {one.name}: {what} = {value}: must be 0 or positive, or -1 for any")
                array[k] = np.inf if value == ERASED else value or array[k]
    allowed = goal.goal_time_tolerance
    goal_time_s = allowed.sec + 1e-9 * allowed.nanosec
    if goal_time_s < 0.0:
        raise ValueError(f"goal_time_tolerance = {goal_time_s} s: must not be negative")
    return Tolerances(path, reached, speeds, goal_time_s or GOAL_TIME_S)
