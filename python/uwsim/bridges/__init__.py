"""Bridges to ROS, Foxglove and autopilots: thin layers on top of uwsim.channels, in separate folders."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.rosbridge import RosbridgeClient, RosbridgeServer

__all__ = ["RosbridgeClient", "RosbridgeServer"]
__getattr__ = lazy(__name__, dict.fromkeys(__all__, "rosbridge"))
