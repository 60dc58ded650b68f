"""Native ROS 1 through Debian's rospy: apt install python3-rospy. See docs/connections/ros1.md."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.ros1.node import Ros1Node
    from uwsim.bridges.ros1.rospy_module import load_rospy, require_master

__all__ = ["Ros1Node", "load_rospy", "require_master"]
__getattr__ = lazy(__name__, {"Ros1Node": "node", "load_rospy": "rospy_module", "require_master": "rospy_module"})
