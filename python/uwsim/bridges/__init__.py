"""Bridges to the world of ROS: thin users of uwsim.channels, each a folder of its own."""

from uwsim.bridges.rosbridge import RosbridgeClient, RosbridgeServer

__all__ = ["RosbridgeClient", "RosbridgeServer"]
