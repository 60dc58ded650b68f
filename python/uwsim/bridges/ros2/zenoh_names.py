"""The names and headers of rmw_zenoh_cpp (docs/design.md, liveliness_utils.cpp and attachment_helpers.cpp).

A topic or a service has the key DOMAIN/NAME/TYPE/HASH. Each node and each endpoint declares a liveliness token, from
which all sessions learn the graph. Each message, request and response carries an attachment.
"""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass

from uwsim.bridges.ros2.settings import Ros2Settings
from uwsim.channels.names import split_node
from uwsim.channels.ros.cdr import store_of
from uwsim.channels.ros.type_hash import type_hash

ATTACHMENT = struct.Struct("<qqB16s")
"""Sequence number, time [ns], length of the identifier, identifier; as in rmw_zenoh since 0.2."""
RELIABLE, BEST_EFFORT = "", "2"  # rmw_qos_reliability_policy_e; the default is left empty
VOLATILE, TRANSIENT_LOCAL = "", "1"


@dataclass(frozen=True)
class Entity:
    """A node or one of its endpoints.

    kind: NN for a node, MP for a publisher, MS for a subscription, SS for a server, SC for a client. session: the
    session's identifier. number: the entity's number in the node. node: its full name. name, type: the topic's or
    service's, without a leading slash.
    """

    kind: str
    settings: Ros2Settings
    session: str
    number: int
    node: str
    name: str = ""
    type: str = ""
    depth: int = 10
    reliable: bool = True
    latched: bool = False

    @property
    def key(self) -> str:
        """The key of the endpoint's topic or service."""
        return f"{self.settings.domain_id}/{self.name}/{self._typed}"

    @property
    def token(self) -> str:
        """The entity's liveliness token."""
        namespace, base = split_node(self.node)
        node = f"{namespace.replace('/', '%')}/{base}"
        own = f"@ros2_lv/{self.settings.domain_id}/{self.session}/0/{self.number}/{self.kind}/%/{node}"
        if not self.name:
            return own
        reliability = RELIABLE if self.reliable else BEST_EFFORT
        durability = TRANSIENT_LOCAL if self.latched else VOLATILE
        qos = f"{reliability}:{durability}:,{self.depth}:,:,:,,"
        return f"{own}/%{self.name.replace('/', '%')}/{self._typed}/{qos}"

    @property
    def _typed(self) -> str:
        package, group, short = self.type.split("/")
        hashed = "TypeHashNotSupported"  # in Humble
        if self.settings.distro != "humble":
            hashed = type_hash(store_of(self.settings.distro), self.type)
        return f"{package}::{group}::dds_::{short}_/{hashed}"


def gid_of(token: str) -> bytes:
    """Return a 16-byte identifier for an endpoint."""
    return hashlib.blake2b(token.encode(), digest_size=16).digest()


def attachment(sequence: int, time_ns: int, gid: bytes) -> bytes:
    """Return an attachment. A response repeats the sequence number and identifier of its request.

    sequence: the number of the message, counted from 1.
    """
    return ATTACHMENT.pack(sequence, time_ns, len(gid), gid)
