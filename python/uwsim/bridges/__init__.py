"""Bridges to ROS and Foxglove: thin users of uwsim.channels, one folder each."""

from uwsim.bridges.rosbridge import RosbridgeClient, RosbridgeServer

__all__ = ["RosbridgeClient", "RosbridgeServer"]
