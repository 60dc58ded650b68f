"""The six axes of a body, in the order of every (6,) array of efforts, velocities and wrenches."""

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
