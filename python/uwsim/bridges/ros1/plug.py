"""`--ros1`: a live simulator or a recording as a node of ROS 1."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from uwsim.base.options import Options, option
from uwsim.bridges.doors.door import EVERYONE, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened


@dataclass(frozen=True)
class Ros1Options(Options):
    """The options of the ROS 1 node."""

    switch = "ros1"

    ros1: bool = option(False, "Also run as a node of ROS 1; see docs/connections/ros1.md.")


class Ros1Plug(BridgePlug[Ros1Options]):
    """The ROS 1 node. Raises ValueError without rospy or a master."""

    options = Ros1Options
    doors = (
        Door("`--ros1`", "TCP", 2, "127.0.0.1 if `ROS_IP` is, else all addresses", "rospy's XML-RPC and TCPROS",
             f"{EVERYONE}; no web page", ("--ros1",)),
    )  # fmt: skip

    def __init__(self, options: Ros1Options) -> None:
        super().__init__(options)
        from uwsim.bridges.ros1 import load_rospy, require_master

        load_rospy(), require_master()

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Run the node."""
        from uwsim.bridges.ros1 import Ros1Node

        with Ros1Node(
            context.live, context.channels, context.services, feed=context.feed, namespace=context.namespace
        ) as node:
            yield Opened(f"ROS 1 at {node.master}", node)
