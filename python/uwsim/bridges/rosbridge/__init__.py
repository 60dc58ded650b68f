"""A rosbridge v2 server and client, for connecting ROS scripts and web pages to the simulator without ROS."""

from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.server import RosbridgeServer
from uwsim.bridges.rosbridge.simulator_client import RosbridgeClient

__all__ = ["Limits", "RosbridgeClient", "RosbridgeServer"]
