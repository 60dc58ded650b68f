"""Native ROS 2 by Eclipse Cyclone DDS, without ROS installed. Needs the extra: pip install 'uwsim[ros2]'."""

from uwsim.extras import need_extra

need_extra("cyclonedds", "ros2", "ROS 2")

from uwsim.bridges.ros2.node import Ros2Node  # noqa: E402
from uwsim.bridges.ros2.settings import Ros2Settings, settings_from  # noqa: E402

__all__ = ["Ros2Node", "Ros2Settings", "settings_from"]
