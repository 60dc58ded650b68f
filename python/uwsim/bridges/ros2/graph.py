"""The ROS 2 graph in DDS: topic names, the node and its endpoints, and type hashes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from uwsim.channels.names import split_node
from uwsim.channels.ros.cdr import Distro, store_of
from uwsim.channels.ros.type_hash import type_hash

ENTITIES = "rmw_dds_common/msg/ParticipantEntitiesInfo"
ENTITIES_TOPIC = "ros_discovery_info"
GID_LENGTH: dict[Distro, int] = {"humble": 24, "jazzy": 16}
PARTICIPANT_DATA = b"enclave=/;"
_NAME = re.compile(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def dds_name(topic: str) -> str:
    """Return the DDS name of a topic such as "scan". Raises ValueError for a name that ROS 2 does not allow."""
    plain = topic.lstrip("/")
    if not _NAME.fullmatch(plain):
        raise ValueError(
            f"topic '{topic}': ROS 2 allows letters, digits and _, and / between names; rename the vehicle"
        )
    return f"rt/{plain}"


def endpoint_data(type_name: str, distro: Distro) -> bytes:
    """Return an endpoint's user data, which in Jazzy contains the type hash."""
    return b"" if distro == "humble" else f"typehash={type_hash(store_of(distro), type_name)};".encode()


def entities_info(
    distro: Distro, participant: bytes, node: str, readers: Sequence[bytes], writers: Sequence[bytes]
) -> Any:
    """Return the message that announces a node and its endpoints, given their 16-byte DDS identifiers.

    node: its full name, without the leading slash.
    """
    types = store_of(distro).types

    def gid(guid: bytes) -> Any:
        return types["rmw_dds_common/msg/Gid"](np.frombuffer(guid.ljust(GID_LENGTH[distro], b"\0"), np.uint8))

    node_info = types["rmw_dds_common/msg/NodeEntitiesInfo"](
        *split_node(node), [gid(guid) for guid in readers], [gid(guid) for guid in writers]
    )
    return types[ENTITIES](gid(participant), [node_info])
