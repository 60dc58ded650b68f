"""The six axes of a body, in the order used by every (6,) array of efforts, velocities or wrenches."""

from typing import Literal, get_args

Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]
AXES: tuple[str, ...] = get_args(Axis)
