"""The paper's processing chain as ROS nodes: five processes that communicate over rosbridge and save a map."""

from uwsim.bridges.nodes.chain import NODES
from uwsim.bridges.nodes.node import Node

__all__ = ["NODES", "Node"]
