"""A rosbridge v2 server and client: ROS users' scripts and web pages meet the simulator, without ROS installed."""

from uwsim.bridges.rosbridge.client import RosbridgeClient
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.server import RosbridgeServer

__all__ = ["Limits", "RosbridgeClient", "RosbridgeServer"]
