"""`--ros2`: a live simulator or a recording as a node of ROS 2."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, need, option
from uwsim.bridges.doors.door import ANYWHERE, EVERYONE, LOOPBACK, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.bridges.doctor import Finding
    from uwsim.bridges.ros2.settings import Ros2Settings


@dataclass(frozen=True)
class Ros2Options(Options):
    """The options of the ROS 2 node, with defaults from the ROS environment variables."""

    switch = "ros2"

    ros2: bool = option(False, "Also run as a node of ROS 2; see docs/connections/ros2.md.")
    ros_distro: str | None = option(
        None,
        "ROS 2: humble or jazzy. Default: the environment's ROS_DISTRO, else jazzy.",
        choices=("humble", "jazzy"),
    )
    ros_domain_id: int | None = option(
        None, "ROS 2: the domain. Default: the environment's ROS_DOMAIN_ID, else 0.", bounds=(0, 232, "")
    )
    ros_reach: str | None = option(None, "ROS 2: localhost (this machine only) or subnet. Default: localhost.")
    ros_peer: tuple[str, ...] = option((), "ROS 2: another host, out of reach of multicast; may be repeated.")
    rmw: str | None = option(
        None,
        "ROS 2: the middleware of its nodes; fastrtps and cyclonedds both work. Default: the environment's "
        "RMW_IMPLEMENTATION, else fastrtps.",
        choices=("fastrtps", "cyclonedds", "zenoh"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.ros_reach in (None, "localhost"):
            need("--ros-reach subnet", ros_peer=self.ros_peer)

    def settings(self) -> Ros2Settings:
        """Return the node's settings. Raises ValueError."""
        from uwsim.bridges.ros2.settings import settings_from

        return settings_from(
            os.environ, distro=self.ros_distro, domain_id=self.ros_domain_id, reach=self.ros_reach or "localhost",
            peers=self.ros_peer, rmw=self.rmw,
        )  # fmt: skip


class Ros2Plug(BridgePlug[Ros2Options]):
    """The ROS 2 node."""

    options = Ros2Options
    examined = ("ros_distro", "ros_domain_id", "ros_reach", "ros_peer")
    doors = (
        Door("`--ros2`", "UDP", 2, ANYWHERE, "DDS: discovery and data",
             f"{EVERYONE}; other hosts are not invited without `--ros-reach subnet`, but nothing here refuses them",
             ("--ros2", "--rmw", "fastrtps")),
        Door("`--ros2`", "UDP", 2, LOOPBACK, "DDS: services, and what is sent", EVERYONE,
             ("--ros2", "--rmw", "fastrtps")),
        Door("`--ros2 --rmw zenoh`, instead", "TCP", 1, LOOPBACK, "Zenoh's sessions", EVERYONE,
             ("--ros2", "--rmw", "zenoh")),
    )  # fmt: skip

    def __init__(self, options: Ros2Options) -> None:
        super().__init__(options)
        from uwsim.bridges.ros2.settings import need_middleware

        self._settings = options.settings()
        need_middleware(self._settings.rmw)

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Run the node."""
        from uwsim.bridges.ros2 import Ros2Node

        with Ros2Node(
            context.live, context.channels, context.services, self._settings, feed=context.feed,
            namespace=context.namespace, actions=context.actions,
        ) as node:  # fmt: skip
            yield Opened(f"ROS 2 {node.settings}", node)

    @classmethod
    def examine(cls, options: Ros2Options, listen_s: float) -> Iterator[Finding]:
        """Yield findings about the domain's participants."""
        from uwsim.bridges.doctor.software import extra

        if extra("ros2").verdict == "ok":
            from uwsim.bridges.doctor.discovery import discovery

            yield from discovery(options.settings(), listen_s)
