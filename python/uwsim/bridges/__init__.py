"""Bridges to the world of ROS: thin users of uwsim.channels, each a folder of its own."""

from uwsim.bridges.rosbridge import RosbridgeServer

__all__ = ["RosbridgeServer"]
