"""The action types in use, as .action definitions: goal, result and feedback."""

from __future__ import annotations

from functools import cache

from rosbags.typesys import get_types_from_msg

from uwsim.channels.ros.cdr import Distro, store_of
from uwsim.channels.ros.interface_types import action_texts, parsed
from uwsim.channels.ros.message_types import ros1_typestore, typestore
from uwsim.channels.ros.service_types import load_service_types

NAVIGATE_TO_POSE, FLY_PATH = "nav2_msgs/action/NavigateToPose", "uwsim_msgs/action/FlyPath"
FOLLOW_JOINTS = "control_msgs/action/FollowJointTrajectory"
ACTION_TYPES = {
    # https://github.com/ros-navigation/navigation2, branch jazzy; Humble's result has other fields
    NAVIGATE_TO_POSE: (
        "geometry_msgs/PoseStamped pose\nstring behavior_tree\n"
        "---\nuint16 NONE=0\nuint16 error_code\nstring error_msg\n"
        "---\ngeometry_msgs/PoseStamped current_pose\nbuiltin_interfaces/Duration navigation_time\n"
        "builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\nfloat32 distance_remaining\n"
    ),
    # https://github.com/ros-controls/control_msgs, branches humble and jazzy
    FOLLOW_JOINTS: (
        "trajectory_msgs/JointTrajectory trajectory\n"
        "trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory\n"
        "control_msgs/JointTolerance[] path_tolerance\n"
        "control_msgs/JointComponentTolerance[] component_path_tolerance\n"
        "control_msgs/JointTolerance[] goal_tolerance\n"
        "control_msgs/JointComponentTolerance[] component_goal_tolerance\n"
        "builtin_interfaces/Duration goal_time_tolerance\n"
        "---\nint32 error_code\nint32 SUCCESSFUL=0\nint32 INVALID_GOAL=-1\nint32 INVALID_JOINTS=-2\n"
        "int32 OLD_HEADER_TIMESTAMP=-3\nint32 PATH_TOLERANCE_VIOLATED=-4\nint32 GOAL_TOLERANCE_VIOLATED=-5\n"
        "string error_string\n"
        "---\nstd_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint desired\n"
        "trajectory_msgs/JointTrajectoryPoint actual\ntrajectory_msgs/JointTrajectoryPoint error\n"
        "string[] multi_dof_joint_names\ntrajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_desired\n"
        "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_actual\n"
        "trajectory_msgs/MultiDOFJointTrajectoryPoint multi_dof_error\n"
    ),
    # Our own
    FLY_PATH: """\
nav_msgs/Path path             # straight legs through these positions; the last orientation is the heading at the end
float64 speed 0.5              # m/s; 0: 0.5
---
bool success
string message                 # why it ended early
float64 duration               # s, simulated
---
geometry_msgs/PoseStamped current_pose
uint32 leg                     # 0: to the first position
float32 distance_remaining     # m, along the path
float64 duration               # s, simulated
""",
}
"""The definitions, by name."""
PARTS = {
    "control_msgs/msg/JointTolerance": "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n",
    "control_msgs/msg/JointComponentTolerance": (
        "uint16 X_AXIS=1\nuint16 Y_AXIS=2\nuint16 Z_AXIS=3\nuint16 TRANSLATION=4\nuint16 ROTATION=5\n"
        "string joint_name\nuint16 component\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n"
    ),
}
"""Message types that only these actions have, from the same sources."""
ONLY_IN_JAZZY = frozenset({NAVIGATE_TO_POSE})


def parts(action_type: str) -> tuple[str, str, str]:
    """Return the definitions of an action type's goal, result and feedback."""
    goal, result, feedback = ACTION_TYPES[action_type].split("---\n")
    return goal, result, feedback


@cache
def load_action_types(distro: Distro = "jazzy") -> None:
    """Add all action types, and the service that cancels goals, to the message types. Repeated calls do nothing."""
    load_service_types(distro)
    found = {part: made for name in ACTION_TYPES for part, made in parsed(action_texts(name, *parts(name))).items()}
    for name, text in PARTS.items():
        found |= get_types_from_msg(text, name)
    for store in (typestore(), ros1_typestore(), store_of(distro)):
        store.register({name: made for name, made in found.items() if name not in store.fielddefs})
