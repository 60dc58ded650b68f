"""The paper's chain as ROS nodes: five processes that talk over rosbridge and end in a saved map."""

from uwsim.bridges.nodes.chain import NODES
from uwsim.bridges.nodes.node import Node

__all__ = ["NODES", "Node"]
