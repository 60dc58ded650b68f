"""A command's bridges in addition to rosbridge: ROS 1 and ROS 2 nodes, and the Foxglove server."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.options import need

if TYPE_CHECKING:
    from uwsim.bridges.actions import Action
    from uwsim.bridges.ros2 import Ros2Settings
    from uwsim.channels import Channel, Service
    from uwsim.channels.feed import Readings
    from uwsim.live import LiveSimulator

Ros1 = Annotated[bool, typer.Option("--ros1", help="Also run as a node of ROS 1; see docs/connections/ros1.md.")]
Ros2 = Annotated[bool, typer.Option("--ros2", help="Also run as a node of ROS 2; see docs/connections/ros2.md.")]
RosDistro = Annotated[
    str | None,
    typer.Option(
        help="ROS 2: humble or jazzy. Default: the environment's ROS_DISTRO, else jazzy.",
        **one_of("humble", "jazzy"),
    ),
]
RosDomain = Annotated[
    int | None,
    typer.Option(help="ROS 2: the domain. Default: the environment's ROS_DOMAIN_ID, else 0.", callback=within(0, 232)),
]
RosReach = Annotated[
    str | None, typer.Option(help="ROS 2: localhost (this machine only) or subnet. Default: localhost.")
]
RosPeers = Annotated[
    list[str] | None, typer.Option(help="ROS 2: another host, out of reach of multicast; may be repeated.")
]
Rmw = Annotated[
    str | None,
    typer.Option(
        "--rmw",
        help="ROS 2: the middleware of its nodes; fastrtps and cyclonedds both work. Default: the environment's "
        "RMW_IMPLEMENTATION, else fastrtps.",
        **one_of("fastrtps", "cyclonedds", "zenoh"),
    ),
]
Foxglove = Annotated[
    bool, typer.Option("--foxglove", help="Also serve the Foxglove app; see docs/connections/foxglove.md.")
]
FoxglovePort = Annotated[int | None, typer.Option(help="Port for Foxglove. Default: 8765.", callback=within(0, 65535))]


def need_subnet(ros_reach: str | None, ros_peer: Sequence[str] | None) -> None:
    """Raise WithoutEffectError if peers are given although only this machine can be reached."""
    if ros_reach in (None, "localhost"):
        need("--ros-reach subnet", ros_peer=ros_peer)


class Bridges:
    """The bridges that options request. Raises ValueError for impossible options, before anything is built."""

    def __init__(
        self,
        *,
        ros1: bool,
        ros2: bool,
        ros_distro: str | None,
        ros_domain_id: int | None,
        ros_reach: str | None,
        ros_peer: Sequence[str] | None,
        rmw: str | None,
        foxglove: bool,
        foxglove_port: int | None,
    ) -> None:
        self._ros1 = ros1
        self._ros2: Ros2Settings | None = None
        self._foxglove_port: int | None = None
        if ros1:
            from uwsim.bridges.ros1 import load_rospy, require_master

            load_rospy(), require_master()
        if ros2:
            need_subnet(ros_reach, ros_peer)
            from uwsim.bridges.ros2 import need_middleware, settings_from

            self._ros2 = settings_from(
                os.environ,
                distro=ros_distro,
                domain_id=ros_domain_id,
                reach=ros_reach or "localhost",
                peers=ros_peer or (),
                rmw=rmw,
            )
            need_middleware(self._ros2.rmw)
        else:
            need(
                "--ros2", ros_distro=ros_distro, ros_domain_id=ros_domain_id, ros_reach=ros_reach, ros_peer=ros_peer,
                rmw=rmw,
            )  # fmt: skip
        if foxglove:
            from uwsim.bridges.foxglove import PORT

            self._foxglove_port = PORT if foxglove_port is None else foxglove_port
        else:
            need("--foxglove", foxglove_port=foxglove_port)

    def __bool__(self) -> bool:
        """Return whether any bridge is requested."""
        return self._ros1 or self._ros2 is not None or self._foxglove_port is not None

    def join(
        self,
        stack: ExitStack,
        channels: Sequence[Channel],
        feed: Readings,
        *,
        live: LiveSimulator | None = None,
        services: Sequence[Service] = (),
        actions: Sequence[Action] = (),
        origin: str = "world",
        namespace: str = "",
        access: Mapping[str, Any] = MappingProxyType({}),
    ) -> list[str]:
        """Open the bridges, which the stack closes; return their addresses, for the greeting.

        origin: the world's origin in odom, as for a Table. namespace: part of the nodes' names. access: the access
        settings from `uwsim.cli.access`.
        """
        started = []
        if self._ros1:
            from uwsim.bridges.ros1 import Ros1Node

            first = stack.enter_context(Ros1Node(live, channels, services, feed=feed, namespace=namespace))
            started.append(f"ROS 1 at {first.master}")
        if self._ros2 is not None:
            from uwsim.bridges.ros2 import Ros2Node

            node = stack.enter_context(
                Ros2Node(live, channels, services, self._ros2, feed=feed, namespace=namespace, actions=actions)
            )
            started.append(f"ROS 2 {node.settings}")
        if self._foxglove_port is not None:
            from uwsim.bridges.foxglove import FoxgloveServer

            app = FoxgloveServer(live, channels, services, port=self._foxglove_port, feed=feed, origin=origin, **access)
            started.append(f"Foxglove at {stack.enter_context(app).url}")
        return started
