"""Native ROS 1 through Debian's rospy: apt install python3-rospy. See docs/connections/ros1.md."""

from uwsim.bridges.ros1.node import Ros1Node
from uwsim.bridges.ros1.rospy_module import load_rospy, require_master

__all__ = ["Ros1Node", "load_rospy", "require_master"]
