"""Refusals: what a rosbridge_server refuses of our requests and messages, as it reports them in the ROS graph's log.

rosbridge_library answers a refused operation with a line on /rosout alone, `[Client 3] [id: ...] advertise: Unable to
load the manifest for package uwsim_msgs`, in which the id is that of the operation (RobotWebTools/rosbridge_suite,
`rosbridge_library/protocol.py`, `Protocol.log`). Lines without an id, such as those of a forbidden name, are ours if
they have our client's number or one of our names. Servers such as `uwsim serve` report by a status instead.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from uwsim.channels.ros.messages import Ros

ROSOUT = "rosout"
ROSOUT_TYPES: dict[Ros, str] = {1: "rosgraph_msgs/Log", 2: "rcl_interfaces/msg/Log"}
INFO: dict[Ros, int] = {1: 2, 2: 20}
WARNING: dict[Ros, int] = {1: 4, 2: 30}
ERROR: dict[Ros, int] = {1: 8, 2: 40}
FORBIDDEN = "No match found for"
"""How the warnings about names that the server is set up to refuse begin; no other warning refuses anything."""
CLIENT = re.compile(r"^\[Client ([^\]]+)\] (?:\[id: ([^\]]*)\] )?(.*)", re.DOTALL)
PACKAGE = re.compile(r"\bpackage '?(\w+)")
OPTIONAL = "?"
"""Follows the mark in the id of a call to a service that the server may lack."""
NAMES_SHOWN, TEXT_SHOWN = 3, 300
FIRST = 3
"""How many messages at the start of a topic must be refused for the topic to be."""
WAYS = {"uwsim_msgs": ", which `uwsim ros package` writes"}


class Refusals:
    """The refused requests and messages of one connection. mark: a unique word, with which each of our ids begins.

    names: the topics and services that the server refused, each with its leading slash. messages: how many messages it
    refused on each topic. first: the reason for the first of them.
    """

    def __init__(self, ros: Ros, mark: str) -> None:
        self._ros: Ros = ros
        self._mark = mark
        self._client: str | None = None  # the server's number for our connection
        self._asked: set[str] = set()
        self._reasons: dict[str, str] = {}
        self._sent: Counter[str] = Counter()
        self._at_first: Counter[str] = Counter()  # refused ones among the first messages of a topic
        self.messages: Counter[str] = Counter()
        self.first: dict[str, str] = {}

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

    def next_id(self, topic: str) -> str:
        """Return the id of the next message on a topic, by which its refusal is recognized."""
        return f"{self._mark} {self._sent[topic] + 1} {topic}"

    def count_sent(self, topic: str) -> None:
        """Record that the next message on a topic is sent."""
        self._sent[topic] += 1

    def refuses(self, name: str) -> bool:
        """Return whether a topic or service was refused."""
        return name in self._reasons

    def refuses_all(self, topics: Iterable[str]) -> bool:
        """Return whether all these topics were refused, or every message on those that were sent."""
        topics = list(topics)
        sent = [topic for topic in topics if self._sent[topic]]
        if not sent:
            return bool(topics) and all(topic in self._reasons for topic in topics)
        return all(topic in self._reasons or self._sent[topic] <= self.messages[topic] for topic in sent)

    def greeting(self) -> list[dict[str, Any]]:
        """Return the requests that subscribe to the log and write a line into it, which returns when it can be read."""
        kind = ROSOUT_TYPES[self._ros]
        return [
            {"op": "subscribe", "topic": f"/{ROSOUT}", "type": kind},
            {"op": "advertise", "topic": f"/{ROSOUT}", "type": kind},
            self.line("connects"),
        ]

    def line(self, text: str) -> dict[str, Any]:
        """Return the request that writes a line into the log; it returns after what is in the log before it."""
        line = {"level": INFO[self._ros], "name": "uwsim", "msg": f"{self._mark} {text}"}
        return {"op": "publish", "topic": f"/{ROSOUT}", "msg": line}

    def is_line(self, message: Mapping[str, Any]) -> bool:
        """Return whether a message of the log is a line of our own."""
        return str(message.get("msg", "")).startswith(self._mark)

    def read(self, message: Mapping[str, Any]) -> str | None:
        """Record a line of the log; return what is to be reported of it at once, if anything."""
        level, found = message.get("level"), CLIENT.match(str(message.get("msg", "")))
        if found is None or not isinstance(level, int) or level < WARNING[self._ros]:
            return None
        client, identity, text = found.groups()
        identity = identity or ""
        if identity.startswith(self._mark):
            self._client = client
        if identity.startswith(f"{self._mark}{OPTIONAL}"):
            return None
        named = identity.removeprefix(self._mark).strip() or next(
            (name for name in self._asked if re.search(rf"{re.escape(name)}(?![\w/])", text)), ""
        )
        if client != self._client and not (self._client is None and named in self._asked):
            return None
        if level < ERROR[self._ros] and not text.startswith(FORBIDDEN):
            return text[:TEXT_SHOWN]  # such as of a service that was offered before a restart
        return self._refused(named, text)

    def read_status(self, operation: Mapping[str, Any]) -> str | None:
        """Record a status; return what is to be reported of it at once, if anything."""
        identity, text = str(operation.get("id", "")), str(operation.get("msg"))
        if operation.get("level") != "error" or not identity.startswith(self._mark):
            return text[:TEXT_SHOWN]
        return self._refused(identity.removeprefix(self._mark).strip(), text)

    def _refused(self, named: str, text: str) -> str | None:
        """Record a refusal. named: the request's name, or the message's number and topic."""
        if named in self._asked:
            self._reasons.setdefault(named, text)
            return None
        number, _, topic = named.partition(" ")
        if topic not in self._sent or not number.isdecimal():
            return text[:TEXT_SHOWN]
        self.messages[topic] += 1
        if int(number) <= FIRST:
            self._at_first[topic] += 1
            if self._at_first[topic] == FIRST:
                self._reasons.setdefault(topic, text)
        if topic in self.first:
            return None
        self.first[topic] = text
        return f"a message on {topic} is refused: {text[:TEXT_SHOWN]}"

    def summary(self) -> list[str]:
        """Return a clause about each kind of refusal: the missing package, or the reason; and the messages' number."""
        by_cause: dict[str, list[str]] = {}
        for name, reason in self._reasons.items():
            package = PACKAGE.search(reason)
            cause = f"it lacks the package {package[1]}{WAYS.get(package[1], '')}" if package else reason[:TEXT_SHOWN]
            by_cause.setdefault(cause, []).append(name)
        found = [f"the server refuses {_shown(names)}: {cause}" for cause, names in sorted(by_cause.items())]
        if self.messages:
            first, topics = next(iter(self.first.values())), _shown(list(self.messages))
            found.append(f"the server has refused {self.messages.total()} messages, on {topics}: {first[:TEXT_SHOWN]}")
        return found


def _shown(names: list[str]) -> str:
    """Return a few names, and the number of the others."""
    others = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return ", ".join(sorted(names)[:NAMES_SHOWN]) + others
