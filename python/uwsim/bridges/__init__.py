"""Bridges to ROS and Foxglove: thin layers over uwsim.channels, one folder each."""

from uwsim.bridges.rosbridge import RosbridgeClient, RosbridgeServer

__all__ = ["RosbridgeClient", "RosbridgeServer"]
