"""Native ROS 2 through Eclipse Cyclone DDS, without ROS. Ros2Node requires the extra: pip install 'uwsim[ros2]'."""

from typing import TYPE_CHECKING, Any

from uwsim.base.extras import need_extra
from uwsim.bridges.ros2.settings import Ros2Settings, settings_from

if TYPE_CHECKING:
    from uwsim.bridges.ros2.node import Ros2Node

__all__ = ["Ros2Node", "Ros2Settings", "settings_from"]


def __getattr__(name: str) -> Any:
    """Import the node on demand, so that settings are available without the extra."""
    if name == "Ros2Node":
        need_extra("cyclonedds", "ros2", "ROS 2")
        from uwsim.bridges.ros2.node import Ros2Node

        return Ros2Node
    raise AttributeError(name)
