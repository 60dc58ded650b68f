"""Bridges to ROS, Foxglove and autopilots: thin layers on top of uwsim.channels, in separate folders."""

from uwsim.bridges.rosbridge import RosbridgeClient, RosbridgeServer

__all__ = ["RosbridgeClient", "RosbridgeServer"]
