"""Names of topics and services in a graph shared with other programs: namespaces."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from uwsim.channels.channel import Channel, Service

SHARED = frozenset({"clock", "tf", "tf_static", "diagnostics"})
"""Topics that all programs in a graph share, whatever their namespace."""
NODE = "uwsim"
NAME_MAX = 200  # characters; ROS 2 allows 255 for a topic
_NAMESPACE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")


def checked_namespace(namespace: str) -> str:
    """Return a namespace without slashes at its ends. Raises ValueError for a namespace that ROS does not allow."""
    plain = namespace.strip("/")
    if plain and not (_NAMESPACE.fullmatch(plain) and len(plain) <= NAME_MAX):
        rule = f"must be letters, digits and _, beginning with a letter, at most {NAME_MAX}"
        raise ValueError(f"namespace = '{namespace[:80]}': {rule}")
    return plain


def node_name(namespace: str) -> str:
    """Return the full name of the simulator's node in a graph, without the leading slash, such as "auv_1/uwsim"."""
    return f"{checked_namespace(namespace)}/{NODE}".removeprefix("/")


def split_node(name: str) -> tuple[str, str]:
    """Return the namespace, such as "/auv_1" or "/", and the base name of a node's full name."""
    namespace, _, base = name.rpartition("/")
    return f"/{namespace}", base


def channels_in(namespace: str, channels: Iterable[Channel]) -> list[Channel]:
    """Return the channels with their names moved to a namespace; "" changes nothing. Raises ValueError."""
    plain = checked_namespace(namespace)
    return [
        replace(channel, name=f"{plain}/{channel.name}") if plain and channel.name not in SHARED else channel
        for channel in channels
    ]


def services_in(namespace: str, services: Iterable[Service]) -> list[Service]:
    """Return the services with their names moved to a namespace; "" changes nothing. Raises ValueError."""
    plain = checked_namespace(namespace)
    return [replace(service, name=f"{plain}/{service.name}") if plain else service for service in services]
