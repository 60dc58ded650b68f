"""ROS 2 without ROS, through Cyclone DDS (pip install 'uwsim[ros2]') or Zenoh (pip install 'uwsim[zenoh]')."""

from typing import TYPE_CHECKING, Any

from uwsim.bridges.ros2.settings import Ros2Settings, need_middleware, settings_from

if TYPE_CHECKING:
    from uwsim.bridges.ros2.node import Ros2Node

__all__ = ["Ros2Node", "Ros2Settings", "need_middleware", "settings_from"]


def __getattr__(name: str) -> Any:
    """Import the node on demand, so that settings are available without the extra."""
    if name == "Ros2Node":
        from uwsim.bridges.ros2.node import Ros2Node

        return Ros2Node
    raise AttributeError(name)
