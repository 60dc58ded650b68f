"""The settings of a ROS 2 node (distribution, domain, reach) and their conversion to a Cyclone DDS configuration."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from uwsim.base.extras import need_extra
from uwsim.channels.ros.cdr import Distro

Reach = Literal["localhost", "subnet"]
Rmw = Literal["fastrtps", "cyclonedds", "zenoh"]
"""The middleware of the ROS side."""
DOMAIN_MAX = 232  # RTPS 2.5, section 9.6.2: the ports of higher domains exceed 65535
SAFE_DOMAIN_MAX = 101  # Linux assigns the ports of higher domains to outgoing connections
ZENOH_PORT = 7447  # a Zenoh router's port
PARTICIPANTS_MAX = 32  # participants probed per host without multicast, as in ROS 2
PORT_BASE, PORTS_PER_DOMAIN, PORTS_PER_PARTICIPANT = 7400, 250, 2  # RTPS 2.5, section 9.6.2.3
UNICAST_OFFSET, MULTICAST_GROUP = 10, "239.255.0.1"

# Nearly the largest UDP packets: a picture in 16 packets costs a third of one in 70.
LOOPBACK_SIZES = "<MaxMessageSize>62000B</MaxMessageSize><FragmentSize>60000B</FragmentSize>"
# By default, a reader's socket buffers 200 kB, which a point cloud overflows while the host is busy. Heartbeats let the
# reader detect what it missed; with the usual 100 ms, only one cloud in five would arrive.
HEARTBEAT = '<HeartbeatInterval min="5ms" minsched="5ms" max="100ms">10ms</HeartbeatInterval>'
# Announce ourselves every second, indefinitely. By default, this happens every 30 s and ends after 30 s, so later nodes
# that are not configured to probe this machine would not find us.
ANNOUNCE = "<SPDPInterval>1s</SPDPInterval><InitialLocatorPruneDelay>inf</InitialLocatorPruneDelay>"
# A reader that stops must not block a writer: the history of ten messages is the limit, not the bytes.
NO_THROTTLE = (
    "<Watermarks><WhcHigh>1GB</WhcHigh><WhcHighInit>1GB</WhcHighInit><WhcAdaptive>false</WhcAdaptive></Watermarks>"
)


@dataclass(frozen=True)
class Ros2Settings:
    """The settings with which a node joins ROS 2.

    distro: the distribution whose types and graph the node uses. domain_id: as in ROS_DOMAIN_ID, [0, 232].

    reach: "localhost" for communication within this machine, "subnet" for all hosts reachable by multicast. peers:
    names or addresses of further hosts that multicast does not reach. rmw: the middleware of the peers. "fastrtps" and
    "cyclonedds" both use DDS and are treated alike. With "zenoh", `peers` are routers on other machines, HOST or
    HOST:PORT. Raises ValueError.
    """

    distro: Distro = "jazzy"
    domain_id: int = 0
    reach: Reach = "localhost"
    peers: tuple[str, ...] = ()
    rmw: Rmw = "fastrtps"

    def __post_init__(self) -> None:
        if self.rmw not in get_args(Rmw):
            raise ValueError(f"ROS 2 rmw = {self.rmw!r}: must be one of {', '.join(get_args(Rmw))}")
        if self.distro not in get_args(Distro):
            raise ValueError(f"ROS 2 distro = {self.distro!r}: must be one of {', '.join(get_args(Distro))}")
        if not 0 <= self.domain_id <= DOMAIN_MAX:
            raise ValueError(f"ROS_DOMAIN_ID = {self.domain_id}: must be in [0, {DOMAIN_MAX}]")
        if self.reach not in get_args(Reach):
            raise ValueError(f"ROS 2 reach = {self.reach!r}: must be one of {', '.join(get_args(Reach))}")
        for peer in self.peers:
            if not peer or any(character in peer for character in "<>&\"' "):
                raise ValueError(f"ROS 2 peer = {peer!r}: must be a host's name or address")

    def __str__(self) -> str:
        """Return a short description, shown at start-up."""
        where = "on this machine alone" if self.reach == "localhost" else "on the subnet"
        return f"{self.distro}, domain {self.domain_id}, {where}" + (" by Zenoh" if self.rmw == "zenoh" else "")

    @property
    def config(self) -> str:
        """The Cyclone DDS configuration in XML. CYCLONEDDS_URI is applied after it and thus overrides it."""
        peers = [*self.peers, *(["127.0.0.1"] if self.reach == "localhost" else [])]
        listed = "".join(f'<Peer Address="{peer}"/>' for peer in peers)
        general = (
            '<Interfaces><NetworkInterface name="lo"/></Interfaces>'
            f"<AllowMulticast>false</AllowMulticast>{LOOPBACK_SIZES}"
            if self.reach == "localhost"
            else ""
        )
        ours = (
            f"<CycloneDDS><Domain Id='any'><General>{general}</General><Discovery>"
            f"<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{PARTICIPANTS_MAX}"
            f"</MaxAutoParticipantIndex>{ANNOUNCE}<Peers>{listed}</Peers></Discovery><Internal>{NO_THROTTLE}{HEARTBEAT}</Internal></Domain></CycloneDDS>"
        )
        theirs = os.environ.get("CYCLONEDDS_URI", "")
        return f"{ours},{theirs}" if theirs else ours


def need_middleware(rmw: Rmw) -> None:
    """Raise MissingExtraError unless the library for a middleware is installed."""
    if rmw == "zenoh":
        need_extra("zenoh", "ROS 2 by Zenoh")
    else:
        need_extra("cyclonedds", "ROS 2")


def settings_from(
    environment: Mapping[str, str],
    *,
    distro: str | None = None,
    domain_id: int | None = None,
    reach: str = "localhost",
    peers: Sequence[str] = (),
    rmw: str | None = None,
) -> Ros2Settings:
    """Return settings from the options, with defaults from the ROS environment variables.

    The variables are ROS_DISTRO and RMW_IMPLEMENTATION (if they are supported), ROS_DOMAIN_ID and ROS_STATIC_PEERS.
    Raises ValueError.
    """
    if distro is None:
        distro = environment.get("ROS_DISTRO", "")
        distro = distro if distro in get_args(Distro) else "jazzy"
    if domain_id is None:
        text = environment.get("ROS_DOMAIN_ID", "") or "0"
        if not text.strip().isdecimal():
            raise ValueError(f"ROS_DOMAIN_ID = {text!r}: must be a whole number in [0, {DOMAIN_MAX}]")
        domain_id = int(text)
    static = [peer for peer in environment.get("ROS_STATIC_PEERS", "").split(";") if peer]
    if rmw is None:
        rmw = environment.get("RMW_IMPLEMENTATION", "").removeprefix("rmw_").removesuffix("_cpp")
        rmw = rmw if rmw in get_args(Rmw) else "fastrtps"
    return Ros2Settings(distro, domain_id, reach, (*static, *peers), rmw)  # type: ignore[arg-type]  # checked there


def unicast_port(domain_id: int, participant: int) -> int:
    """Return the UDP port for discovery of a domain's participant; each host numbers its participants from 0."""
    return PORT_BASE + PORTS_PER_DOMAIN * domain_id + UNICAST_OFFSET + PORTS_PER_PARTICIPANT * participant


def multicast_port(domain_id: int) -> int:
    """Return the UDP port on which a domain's participants announce themselves to MULTICAST_GROUP."""
    return PORT_BASE + PORTS_PER_DOMAIN * domain_id
