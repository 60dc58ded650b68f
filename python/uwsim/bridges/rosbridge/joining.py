"""Joining: asks a rosbridge_server which ROS it is of, and follows what it refuses of a client's requests and messages.

The generations refuse each other's messages: ROS 2 has no header.seq, and spells the fields of a time otherwise. A
server is asked in turn for what it has: rosapi's time, whose fields it spells; rosapi's version; and a Header of ours
without a time, which it sends back with all of its fields.

rosbridge_library answers a refused operation with a line on /rosout alone, `[Client 3] [id: ...] advertise: Unable to
load the manifest for package uwsim_msgs`, in which the id is that of the operation (RobotWebTools/rosbridge_suite,
`rosbridge_library/protocol.py`, `Protocol.log`). Lines without an id, such as those of a forbidden name, are ours if
they have our client's number or one of our names. Servers such as `uwsim serve` report by a status instead.
"""

from __future__ import annotations

import asyncio
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from logging import Logger
from typing import Any

from websockets.asyncio.client import ClientConnection

from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.channels.ros.messages import Ros

TURN_S = 2.0
"""How long to wait for an answer before the next question [s]."""
HEADERS = 3
"""How often the Header is sent, since a graph may take a while to connect a topic's two ends."""
TOPIC, HEADER = "/uwsim_asks", "std_msgs/Header"
LOG_WAIT_S = 2.0
"""For a line of ours to come back from the ROS graph's log."""
REFUSALS_S = 1.0
"""Without a further refusal, after which those collected are logged."""
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

Operation = dict[str, Any]


class RefusedError(ValueError):
    """Raised for a server that refuses all that it is sent."""


class Joining:
    """One connection's questions and refusals.

    given: the server's ROS generation if it does not show it. sends: the topics that the client sends, each with its
    leading slash. mark: a unique word, with which the ids of its requests begin. report: called with what the server
    reports. ros: the generation, known after `begin`. reasons: of the topics and services that the server refused, by
    name with its leading slash. sentences: what it refuses, as logged.
    """

    def __init__(
        self, connection: ClientConnection, given: Ros | None, sends: Iterable[str], log: Logger, url: str,
        mark: str, report: Callable[[str], object],
    ) -> None:  # fmt: skip
        self._connection, self._given, self._sends, self._url = connection, given, list(sends), url
        self._log, self._mark, self._report = log, mark, report
        self._answered, self._reads_log = asyncio.Event(), asyncio.Event()
        self._shown: Ros | None = None
        self._has_topic = False
        self._said: set[str] = set()
        self._client: str | None = None  # the server's number for our connection
        self._asked: set[str] = set()
        self._sent: Counter[str] = Counter()
        self._refused_at_first: Counter[str] = Counter()
        self._messages: Counter[str] = Counter()  # refused, by topic
        self._first: dict[str, str] = {}  # the reason for the first of them
        self.reasons: dict[str, str] = {}
        self.sentences = ""
        self.ros: Ros = given or 1

    async def begin(self) -> None:
        """Learn the server's generation, and subscribe to the graph's log, which alone has refusals."""
        for question in self._questions():
            self._answered.clear()
            await self._send(question)
            with suppress(TimeoutError):
                async with asyncio.timeout(TURN_S):
                    await self._answered.wait()
            if self._shown is not None:
                break
        await self._send({"op": op, "topic": TOPIC} for op in ("unsubscribe", "unadvertise") if self._has_topic)
        self.ros = self._shown or self.ros
        if self._shown is None and self._given is None:
            self._warn("it does not show whether it is of ROS 1 or 2: used as ROS 1; --ros 2 changes that")
        elif self._given not in (None, self.ros):
            self._warn(f"it is of ROS {self.ros}: ROS {self._given}, as given, is not used")
        both = {"topic": f"/{ROSOUT}", "type": ROSOUT_TYPES[self.ros]}
        await self._send([{"op": "subscribe", **both}, {"op": "advertise", **both}, self._line("connects")])
        if not await self._log_is_read():
            self._warn(f"/{ROSOUT} cannot be read: refusals by the server remain unknown")

    def _questions(self) -> Iterator[list[Operation]]:
        """Yield the operations of each question."""
        for service in ("get_time", "get_ros_version"):
            name = f"/rosapi/{service}"
            yield [{"op": "call_service", "service": name, "id": f"{self._mark}{OPTIONAL} {service}", "args": {}}]
        self._has_topic = True
        sent = {"op": "publish", "topic": TOPIC, "msg": {"frame_id": self._mark}}
        both = {"topic": TOPIC, "type": HEADER}
        yield [{"op": "advertise", **both}, {"op": "subscribe", **both}, sent]
        for _ in range(HEADERS - 1):
            yield [sent]

    async def introduce(self, operations: Iterable[Operation]) -> None:
        """Send what introduces the client, each with an id. Raises RefusedError if the server refuses every topic."""
        for operation in operations:
            name = str(operation.get("topic") or operation.get("service"))
            self._asked.add(name)
            await self._send([operation | {"id": f"{self._mark} {name}"}])
        await self.is_refused()
        self.require_topics()

    def next_id(self, topic: str) -> str:
        """Return the id of the next message on a topic, by which its refusal is recognized."""
        self._sent[topic] += 1
        return f"{self._mark} {self._sent[topic]} {topic}"

    async def is_refused(self) -> bool:
        """Return whether all so far was refused, after waiting until that is known."""
        if self._reads_log.is_set():
            self._reads_log.clear()
            await self._send([self._line("asks")])
            await self._log_is_read()
            self._reads_log.set()
        return self._refuses_all()

    def require_topics(self) -> None:
        """Raise RefusedError if every topic was refused, or every message so far."""
        if self._refuses_all():
            sentences = self._summary()
            self._said.update(sentences)  # by the error
            raise RefusedError("; ".join(sentences))

    async def follow_refusals(self) -> None:
        """Log refusals when no further one has followed for REFUSALS_S. Raises RefusedError once all is refused."""
        reported = seen = 0
        while True:
            await asyncio.sleep(REFUSALS_S)
            if reported != seen == len(self.reasons):
                reported = seen
                self.require_topics()
                self.log_refusals()
            seen = len(self.reasons)

    def log_refusals(self) -> None:
        """Log what the server refuses, unless it was logged."""
        sentences = self._summary()
        self.sentences = "; ".join(sentences)
        for sentence in sentences:
            if sentence not in self._said:
                self._warn(sentence)
        self._said.update(sentences)

    def read(self, operation: Operation) -> bool:
        """Take an answer to a question, a line of the log or a status; return whether it was one of these."""
        op, topic, identity = operation.get("op"), operation.get("topic"), str(operation.get("id", ""))
        values = operation.get("values" if op == "service_response" else "msg")
        if op == "service_response" and identity.startswith(f"{self._mark}{OPTIONAL} get_"):
            self._learn(values, "version", "time")
        elif op == "publish" and topic in (TOPIC, TOPIC[1:]):
            self._learn(values, "", "stamp")
        elif op == "publish" and topic in (f"/{ROSOUT}", ROSOUT):
            self._read_line(values if isinstance(values, dict) else {})
        elif op == "status" and operation.get("level") == "error" and identity.startswith(self._mark):
            self._refused(identity.removeprefix(self._mark).strip(), str(values))
        elif op == "status":
            self._report(str(values)[:TEXT_SHOWN])
        else:
            return False
        return True

    def _learn(self, values: Any, version: str, time: str) -> None:
        """Take the generation that an answer shows, by its version or by how it spells the fields of a time."""
        if isinstance(values, dict):
            known, fields = values.get(version), values.get(time)
            spelt = fields if isinstance(fields, dict) else ()
            of_time: Ros | None = 2 if "sec" in spelt else 1 if "secs" in spelt else None
            self._shown = self._shown or (1 if known == 1 else 2 if known == 2 else of_time)
        self._answered.set()

    def _read_line(self, message: Operation) -> None:
        level, text = message.get("level"), str(message.get("msg", ""))
        if text.startswith(self._mark):
            self._reads_log.set()
        found = CLIENT.match(text)
        if found is None or not isinstance(level, int) or level < WARNING[self.ros]:
            return
        client, identity, text = found[1], found[2] or "", found[3]
        if identity.startswith(self._mark):
            self._client = client
        if identity.startswith(f"{self._mark}{OPTIONAL}"):
            return
        named = identity.removeprefix(self._mark).strip() or next(
            (name for name in self._asked if re.search(rf"{re.escape(name)}(?![\w/])", text)), ""
        )
        if client != self._client and not (self._client is None and named in self._asked):
            return
        if level < ERROR[self.ros] and not text.startswith(FORBIDDEN):
            self._report(text[:TEXT_SHOWN])  # such as of a service that was offered before a restart
        else:
            self._refused(named, text)

    def _refused(self, named: str, text: str) -> None:
        """Record a refusal. named: the request's name, or the message's number and topic."""
        number, _, topic = named.partition(" ")
        if named in self._asked:
            self.reasons.setdefault(named, text)
        elif topic not in self._sent or not number.isdecimal():
            self._report(text[:TEXT_SHOWN])
        else:
            self._messages[topic] += 1
            self._refused_at_first[topic] += int(number) <= FIRST
            if self._refused_at_first[topic] == FIRST:
                self.reasons.setdefault(topic, text)
            if topic not in self._first:
                self._first[topic] = text
                self._report(f"a message on {topic} is refused: {text[:TEXT_SHOWN]}")

    def _refuses_all(self) -> bool:
        """Return whether all topics were refused, or every message on those that were sent."""
        sent = [topic for topic in self._sends if self._sent[topic]]
        if not sent:
            return bool(self._sends) and all(topic in self.reasons for topic in self._sends)
        return all(topic in self.reasons or self._sent[topic] <= self._messages[topic] for topic in sent)

    def _summary(self) -> list[str]:
        """Return a clause about each kind of refusal: the missing package, or the reason; and the messages' number."""
        by_cause: dict[str, list[str]] = {}
        for name, reason in self.reasons.items():
            package = PACKAGE.search(reason)
            cause = f"it lacks the package {package[1]}{WAYS.get(package[1], '')}" if package else reason[:TEXT_SHOWN]
            by_cause.setdefault(cause, []).append(name)
        found = [f"the server refuses {_listed(names)}: {cause}" for cause, names in sorted(by_cause.items())]
        if self._messages:
            first, topics = next(iter(self._first.values())), _listed(self._messages)
            found.append(f"the server has refused {self._messages.total()} messages, on {topics}: {first[:TEXT_SHOWN]}")
        return found

    def _line(self, text: str) -> Operation:
        """Return the request that writes a line into the log; it returns after what is in the log before it."""
        line = {"level": INFO[self.ros], "name": "uwsim", "msg": f"{self._mark} {text}"}
        return {"op": "publish", "topic": f"/{ROSOUT}", "msg": line}

    async def _log_is_read(self) -> bool:
        """Return whether a line of ours has come back from the log, after waiting for it."""
        with suppress(TimeoutError):
            async with asyncio.timeout(LOG_WAIT_S):
                return await self._reads_log.wait()
        return False

    def _warn(self, text: str) -> None:
        self._log.warning("%s: %s", self._url, text)

    async def _send(self, operations: Iterable[Operation]) -> None:
        for operation in operations:
            await self._connection.send(to_json(operation))


def _listed(names: Iterable[str]) -> str:
    """Return a few names, and the number of the others."""
    names = sorted(names)
    others = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return ", ".join(names[:NAMES_SHOWN]) + others
