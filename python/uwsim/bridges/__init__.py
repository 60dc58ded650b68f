"""Bridges to ROS and Foxglove: thin layers on top of uwsim.channels, one folder each."""

from uwsim.bridges.rosbridge import RosbridgeClient, RosbridgeServer

__all__ = ["RosbridgeClient", "RosbridgeServer"]
