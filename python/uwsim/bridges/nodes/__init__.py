"""The paper's processing chain as ROS nodes: five processes that communicate over rosbridge and save a map."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.nodes.chain import NODES
    from uwsim.bridges.nodes.node import Node

__all__ = ["NODES", "Node"]
__getattr__ = lazy(__name__, {"NODES": "chain", "Node": "node"})
