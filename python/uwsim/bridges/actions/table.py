"""The table of actions; a new action is one entry here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.actions.action import Action, Offered, Progress, Route
from uwsim.bridges.actions.joints import JointAction
from uwsim.channels import Table
from uwsim.channels.families.commands import CONTROLLER, joint_limits
from uwsim.channels.families.estimate import has_estimate
from uwsim.channels.ros import build
from uwsim.channels.ros.action_types import FLY_PATH, FOLLOW_JOINTS, NAVIGATE_TO_POSE, load_action_types
from uwsim.channels.source import Source
from uwsim.missions.moves import SPEED_MAX_M_S
from uwsim.simulator.simulator import Simulator

SPEED_M_S = 0.5
POINTS_MAX = 10_000
POSITION_MAX_M = 1e6
FAILED = 9000  # error_code of nav2_msgs/NavigateToPose since Kilted: UNKNOWN
UNIT = 0.01  # tolerance of the norm of a quaternion


def actions_of(sim: Simulator, table: Table) -> list[Offered]:
    """Return the actions of all vehicles.

    A vehicle has no actions if commands to it go over a modem, which an action would bypass, and no flights if the
    truth is hidden and it has no IMU with which to estimate its pose.
    """
    if sim.link is not None:
        return []
    uses_truth = table.tf == "truth"
    load_action_types()
    found: list[Offered] = []
    for source in table.sources:
        if uses_truth or has_estimate(source):
            found += _actions(source, table, uses_truth)
        arm = source.of(sim).arm
        if arm is not None and arm.motors:
            found.append(
                JointAction(
                    source.topic(f"{CONTROLLER}/follow_joint_trajectory"), FOLLOW_JOINTS, "move joints through points",
                    source, table.steering[source.name], joint_limits(source, arm.motors),
                )
            )  # fmt: skip
    return found


def _actions(source: Source, table: Table, uses_truth: bool) -> list[Action]:
    shared: dict[str, Any] = {"source": source, "steering": table.steering[source.name], "uses_truth": uses_truth}
    return [
        Action(
            source.topic("navigate_to_pose"), NAVIGATE_TO_POSE, "fly to a pose in odom, map or world", **shared,
            route=lambda goal: _route(source, table, [goal.pose], SPEED_M_S),
            feedback=_navigate_feedback,
            result=lambda elapsed_s, why: build.message(
                f"{NAVIGATE_TO_POSE}_Result", error_code=FAILED if why else 0, error_msg=why
            ),
        ),
        Action(
            source.topic("fly_path"), FLY_PATH, "fly straight legs through poses in odom, map or world", **shared,
            route=lambda goal: _route(source, table, goal.path.poses, goal.speed, goal.path.header.frame_id),
            feedback=lambda now: build.message(
                f"{FLY_PATH}_Feedback", current_pose=now.pose, leg=now.leg, distance_remaining=now.remaining_m,
                duration=now.elapsed_s,
            ),
            result=lambda elapsed_s, why: build.message(
                f"{FLY_PATH}_Result", success=not why, message=why, duration=elapsed_s
            ),
        ),
    ]  # fmt: skip


def _navigate_feedback(now: Progress) -> Any:
    return build.message(
        f"{NAVIGATE_TO_POSE}_Feedback",
        current_pose=now.pose,
        navigation_time=build.duration(now.elapsed_s),
        estimated_time_remaining=build.duration(now.remaining_m / SPEED_M_S),
        distance_remaining=now.remaining_m,
    )


def _route(source: Source, table: Table, poses: Sequence[Any], speed_m_s: float, frame_id: str = "") -> Route:
    """Return the route through poses (PoseStamped). frame_id: the frame of poses without one. Raises ValueError."""
    if not 1 <= len(poses) <= POINTS_MAX:
        raise ValueError(f"{len(poses)} poses: must be 1 to {POINTS_MAX}")
    if not 0.0 <= speed_m_s <= SPEED_MAX_M_S:  # false for NaN as well
        raise ValueError(f"speed = {speed_m_s} m/s: must be in [0, {SPEED_MAX_M_S:g}]")
    points = np.array([_point(source, table, pose, frame_id) for pose in poses])
    return Route(points, speed_m_s or SPEED_M_S, _heading_rad(poses[-1].pose.orientation))


def _point(source: Source, table: Table, stamped: Any, frame_id: str) -> NDArray[np.float64]:
    """Return a position in the world frame, (3,)."""
    frame = stamped.header.frame_id or frame_id
    at = stamped.pose.position
    point = np.array([at.x, at.y, at.z])
    if not (np.isfinite(point).all() and np.abs(point).max() <= POSITION_MAX_M):
        raise ValueError(f"position = {point.tolist()} m: must be finite and within {POSITION_MAX_M:g}")
    own = (source.frame("odom"), f"{table.frame_prefix}map")
    if frame in ("", *own):
        point = point - source.origin_m
    elif frame != "world":
        raise ValueError(f"frame_id = '{frame}': must be {', '.join(own)} or world")
    if point[2] > 0.0:
        raise ValueError(f"position is {point[2]:.2f} m above the water's surface: must not be above it")
    return point


def _heading_rad(orientation: Any) -> float | None:
    """Return the yaw of a quaternion, or None if it is all zeros. Raises ValueError."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    if x == y == z == w == 0.0:
        return None
    if not abs(math.sqrt(x * x + y * y + z * z + w * w) - 1.0) <= UNIT:
        raise ValueError(f"orientation = ({x}, {y}, {z}, {w}): must be a unit quaternion, or zeros for any heading")
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
