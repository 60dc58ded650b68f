"""A rosbridge v2 server and client, for connecting ROS scripts and web pages to the simulator without ROS."""

from uwsim.bridges.rosbridge.client import RosbridgeClient
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.server import RosbridgeServer

__all__ = ["Limits", "RosbridgeClient", "RosbridgeServer"]
