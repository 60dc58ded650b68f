"""The action types in use, as .action definitions: goal, result and feedback."""

from __future__ import annotations

from functools import cache

from uwsim.channels.ros.cdr import Distro, store_of
from uwsim.channels.ros.interface_types import action_texts, parsed
from uwsim.channels.ros.message_types import ros1_typestore, typestore
from uwsim.channels.ros.service_types import load_service_types

NAVIGATE_TO_POSE, FLY_PATH = "nav2_msgs/action/NavigateToPose", "uwsim_msgs/action/FlyPath"
ACTION_TYPES = {
    # https://github.com/ros-navigation/navigation2, branch jazzy; Humble's result has other fields
    NAVIGATE_TO_POSE: (
        "geometry_msgs/PoseStamped pose\nstring behavior_tree\n"
        "---\nuint16 NONE=0\nuint16 error_code\nstring error_msg\n"
        "---\ngeometry_msgs/PoseStamped current_pose\nbuiltin_interfaces/Duration navigation_time\n"
        "builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\nfloat32 distance_remaining\n"
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
    for store in (typestore(), ros1_typestore(), store_of(distro)):
        store.register({name: made for name, made in found.items() if name not in store.fielddefs})
