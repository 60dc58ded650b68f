"""Scenarios from the robot and world descriptions of other simulators: SDF, URDF and Stonefish's."""
