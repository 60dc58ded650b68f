"""Packages for ROS 1 and ROS 2: uwsim's own messages, a launch file and an RViz configuration."""

from uwsim.bridges.ros_packages.content import ros_packages
from uwsim.bridges.ros_packages.write import write_sealed

__all__ = ["ros_packages", "write_sealed"]
