"""ROS 2 without ROS, through Cyclone DDS (pip install 'uwsim[ros2]') or Zenoh (pip install 'uwsim[zenoh]')."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.ros2.node import Ros2Node
    from uwsim.bridges.ros2.settings import Ros2Settings, need_middleware, settings_from

__all__ = ["Ros2Node", "Ros2Settings", "need_middleware", "settings_from"]
__getattr__ = lazy(__name__, {"Ros2Node": "node", **dict.fromkeys(__all__[1:], "settings")})
