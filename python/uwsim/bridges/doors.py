"""The sockets that each option opens: the source of the table in SECURITY.md, which tools/reference writes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LOOPBACK, ANYWHERE, HOST = "127.0.0.1", "all addresses", "`--host`, by default 127.0.0.1"


@dataclass(frozen=True)
class Door:
    """Sockets on which a program receives. option: what opens them; names: whom they serve.

    count: how many they are, by default. address: where they listen. admits: who may enter, and how that is limited.
    """

    option: str
    protocol: Literal["TCP", "UDP"]
    count: int
    address: str
    serves: str
    admits: str


WEB = "pages of this machine and `--page`, other programs; with `--token` only who sends it; `--certfile` encrypts"
EVERYONE = "every program that reaches the address"

DOORS = (
    Door("`serve`, `station`, `replay --as-topics`, `exercise --serve`", "TCP", 1, HOST, "rosbridge and the page", WEB),
    Door("`--foxglove`", "TCP", 1, HOST, "Foxglove", WEB),
    Door("`--mavlink tcp`", "TCP", 1, "its own, by default 127.0.0.1", "MAVLink",
         f"{EVERYONE}, from its first valid message; no web page"),
    Door("`--mavlink udpin`", "UDP", 1, "its own, by default 127.0.0.1", "MAVLink",
         f"{EVERYONE}, from its first valid message"),
    Door("`--mavlink udpout`", "UDP", 1, "its own, by default 127.0.0.1", "MAVLink", "the program at the target"),
    Door("`--nmea tcp`", "TCP", 1, "its own, by default 127.0.0.1", "NMEA 0183",
         f"{EVERYONE}; nothing is read from it"),
    Door("`--nmea udp`", "UDP", 1, "127.0.0.1 if the target is local", "NMEA 0183", "no program: nothing is read"),
    Door("`--ardusub`", "UDP", 1, "`--ardusub-host`, by default 127.0.0.1", "ArduSub's servo outputs",
         f"{EVERYONE}; while one sends frames, no other"),
    Door("`--ardusub-binary`", "UDP", 1, LOOPBACK, "the firmware's navigation",
         "the first program that sends, until the firmware starts again"),
    Door("`--ardusub-binary`", "UDP", 2, ANYWHERE, "in the firmware: RC input at port 5501, motion at a free port",
         f"{EVERYONE}; the first steers, the second moves: a firewall must close them"),
    Door("`--ardusub-binary`", "UDP", 2, "127.0.0.1 if `--ardusub-station` is", "in the firmware: MAVLink",
         "the station and this program"),
    Door("`--video`", "UDP", 2, "127.0.0.1 if the target is local, else all addresses", "ffmpeg's RTP and RTCP",
         "reports on the reception; they have no effect"),
    Door("`--ros1`", "TCP", 2, "127.0.0.1 if `ROS_IP` is, else all addresses", "rospy's XML-RPC and TCPROS",
         f"{EVERYONE}; no web page"),
    Door("`--ros2`", "UDP", 2, ANYWHERE, "DDS: discovery and data",
         f"{EVERYONE}; other hosts are not invited without `--ros-reach subnet`, but nothing here refuses them"),
    Door("`--ros2`", "UDP", 2, LOOPBACK, "DDS: services, and what is sent", EVERYONE),
    Door("`--ros2 --rmw zenoh`, instead", "TCP", 1, LOOPBACK, "Zenoh's sessions", EVERYONE),
)  # fmt: skip
"""All doors, except for those of Dask's workers, whose number depends on theirs, and of `uwsim ardusub-check`."""


def table() -> str:
    """Return the doors as a table in Markdown."""
    lines = ["| option | sockets | at | for | admits |", "|---|---|---|---|---|"]
    lines += [
        f"| {door.option} | {door.count} {door.protocol} | {door.address} | {door.serves} | {door.admits} |"
        for door in DOORS
    ]
    return "\n".join(lines)
