"""Refusals: what a rosbridge_server refuses of our requests, as it reports them in the ROS graph's log.

rosbridge_library answers a refused `advertise` or `advertise_service` with a line on /rosout alone,
`[Client 3] [id: ...] advertise: Unable to load the manifest for package uwsim_msgs`, in which the id is that of the
request (RobotWebTools/rosbridge_suite, `rosbridge_library/protocol.py`, `Protocol.log`). Lines without an id, such as
those of a forbidden name, are ours if they have our client's number or one of our names.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from uwsim.channels.ros.messages import Ros

ROSOUT = "rosout"
ROSOUT_TYPES: dict[Ros, str] = {1: "rosgraph_msgs/Log", 2: "rcl_interfaces/msg/Log"}
INFO: dict[Ros, int] = {1: 2, 2: 20}
WARNING: dict[Ros, int] = {1: 4, 2: 30}
CLIENT = re.compile(r"^\[Client ([^\]]+)\] (?:\[id: ([^\]]*)\] )?(.*)", re.DOTALL)
PACKAGE = re.compile(r"\bpackage '?(\w+)")
NAMES_SHOWN, TEXT_SHOWN = 3, 300
WAYS = {"uwsim_msgs": ", which `uwsim ros package` writes"}


class Refusals:
    """The refused requests of one connection. mark: a unique word, with which the id of each request begins."""

    def __init__(self, ros: Ros, mark: str) -> None:
        self._ros: Ros = ros
        self._mark = mark
        self._client: str | None = None  # the server's number for our connection
        self._asked: set[str] = set()
        self._reasons: dict[str, str] = {}

    @property
    def names(self) -> frozenset[str]:
        """The topics and services that the server refused, each with its leading slash."""
        return frozenset(self._reasons)

    def marked(self, operations: Iterable[dict[str, Any]]) -> Iterable[dict[str, Any]]:
        """Give each request an id by which its refusal is recognized."""
        for operation in operations:
            name = str(operation.get("topic") or operation.get("service"))
            self._asked.add(name)
            yield operation | {"id": f"{self._mark} {name}"}

    def greeting(self) -> list[dict[str, Any]]:
        """Return the requests that subscribe to the log and write a line into it, which returns when it can be read."""
        kind = ROSOUT_TYPES[self._ros]
        line = {"level": INFO[self._ros], "name": "uwsim", "msg": f"{self._mark} connects"}
        return [
            {"op": "subscribe", "topic": f"/{ROSOUT}", "type": kind},
            {"op": "advertise", "topic": f"/{ROSOUT}", "type": kind},
            {"op": "publish", "topic": f"/{ROSOUT}", "msg": line},
        ]

    def is_greeting(self, message: Mapping[str, Any]) -> bool:
        """Return whether a message of the log is our own line."""
        return str(message.get("msg", "")).startswith(self._mark)

    def read(self, message: Mapping[str, Any]) -> str | None:
        """Record a refusal; return the line if it concerns us and refuses no request, such as one about a message."""
        level, found = message.get("level"), CLIENT.match(str(message.get("msg", "")))
        if found is None or not isinstance(level, int) or level < WARNING[self._ros]:
            return None
        client, identity, text = found.groups()
        identity = identity or ""
        if identity.startswith(self._mark):
            self._client = client
        named = identity.removeprefix(self._mark).strip() or next(
            (name for name in self._asked if re.search(rf"{re.escape(name)}(?![\w/])", text)), ""
        )
        if client != self._client and not (self._client is None and named in self._asked):
            return None
        if named in self._asked:
            self._reasons.setdefault(named, text)
            return None
        return text[:TEXT_SHOWN]

    def summary(self) -> list[str]:
        """Return a clause about each kind of refusal: the missing package, or the reason."""
        by_cause: dict[str, list[str]] = {}
        for name, reason in self._reasons.items():
            package = PACKAGE.search(reason)
            cause = f"it lacks the package {package[1]}{WAYS.get(package[1], '')}" if package else reason[:TEXT_SHOWN]
            by_cause.setdefault(cause, []).append(name)
        return [f"the server refuses {_shown(names)}: {cause}" for cause, names in sorted(by_cause.items())]


def _shown(names: list[str]) -> str:
    """Return a few names, and the number of the others."""
    others = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return ", ".join(sorted(names)[:NAMES_SHOWN]) + others
