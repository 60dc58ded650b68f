"""Joining: asks a rosbridge_server which ROS it is of, introduces a client to it, and follows what it refuses."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Iterable
from contextlib import suppress
from logging import Logger
from typing import Any

from websockets.asyncio.client import ClientConnection

from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.generation import TURN_S, Generation, Operation, chosen
from uwsim.bridges.rosbridge.refusals import OPTIONAL, ROSOUT, Refusals
from uwsim.channels.ros.messages import Ros

LOG_WAIT_S = 2.0
"""For a line of ours to come back from the ROS graph's log."""
REFUSALS_S = 1.0
"""Without a further refusal, after which those collected are logged."""


class RefusedError(ValueError):
    """Raised for a server that refuses all that it is sent."""


class Joining:
    """One connection's questions and refusals.

    given: the server's ROS generation if it does not show it. sends: the topics that the client sends, each with its
    leading slash. ros: the generation, known after `begin`. refusals: what the server refuses. sentences: the same,
    as logged.
    """

    def __init__(
        self, connection: ClientConnection, given: Ros | None, sends: Iterable[str], log: Logger, url: str
    ) -> None:
        self._connection, self._given, self._sends, self._url = connection, given, list(sends), url
        self._log, self._rare = log, RareLog(log)
        self._mark = f"uwsim-{secrets.token_hex(4)}"
        self._generation = Generation(f"{self._mark}{OPTIONAL}")
        self._answered, self._reads_log = asyncio.Event(), asyncio.Event()
        self._said: set[str] = set()
        self.sentences = ""
        self.ros: Ros = given or 1
        self.refusals = Refusals(self.ros, self._mark)

    async def begin(self) -> None:
        """Learn the server's generation, and subscribe to the graph's log, which alone has refusals."""
        for question in self._generation.questions():
            self._answered.clear()
            await self._send(question)
            with suppress(TimeoutError):
                async with asyncio.timeout(TURN_S):
                    await self._answered.wait()
            if self._generation.ros is not None:
                break
        await self._send(self._generation.ends())
        self.ros, remark = chosen(self._generation.ros, self._given)
        if remark:
            self._log.warning("%s: %s", self._url, remark)
        self.refusals = Refusals(self.ros, self._mark)
        await self._send(self.refusals.greeting())
        if not await self._log_is_read():
            self._log.warning("%s: /%s cannot be read: refusals by the server remain unknown", self._url, ROSOUT)

    async def call(self, service: str, arguments: dict[str, Any]) -> None:
        """Call a service that the server may lack, without waiting for the answer."""
        name = f"{self._mark}{OPTIONAL} {service}"
        await self._send([{"op": "call_service", "service": service, "id": name, "args": arguments}])

    async def introduce(self, operations: Iterable[Operation]) -> None:
        """Send what introduces the client. Raises RefusedError if the server refuses every topic."""
        await self._send(self.refusals.marked(operations))
        await self.is_refused()
        self.require_topics()

    async def is_refused(self) -> bool:
        """Return whether all so far was refused, after waiting until that is known."""
        if self._reads_log.is_set():
            self._reads_log.clear()
            await self._send([self.refusals.line("asks")])
            await self._log_is_read()
            self._reads_log.set()
        return self.refusals.refuses_all(self._sends)

    def require_topics(self) -> None:
        """Raise RefusedError if every topic was refused, or every message so far."""
        if self.refusals.refuses_all(self._sends):
            sentences = self.refusals.summary()
            self._said.update(sentences)  # by the error
            raise RefusedError("; ".join(sentences))

    async def follow_refusals(self) -> None:
        """Log refusals when no further one has followed for REFUSALS_S. Raises RefusedError once all is refused."""
        reported = seen = frozenset[str]()
        while True:
            await asyncio.sleep(REFUSALS_S)
            if reported != seen == self.refusals.names:
                reported = seen
                self.require_topics()
                self.log_refusals()
            seen = self.refusals.names

    def log_refusals(self) -> None:
        """Log what the server refuses, unless it was logged."""
        sentences = self.refusals.summary()
        self.sentences = "; ".join(sentences)
        for sentence in sentences:
            if sentence not in self._said:
                self._log.warning("%s: %s", self._url, sentence)
        self._said.update(sentences)

    def read(self, operation: Operation) -> bool:
        """Take an answer, a line of the log or a status; return whether it was one of these."""
        op = operation.get("op")
        if self._generation.read(operation):
            self._answered.set()
        elif op == "publish" and str(operation.get("topic")).lstrip("/") == ROSOUT:
            message = operation.get("msg")
            if isinstance(message, dict) and self.refusals.is_line(message):
                self._reads_log.set()
            elif isinstance(message, dict):
                self._report(self.refusals.read(message))
        elif op == "status":
            self._report(self.refusals.read_status(operation))
        else:
            return False
        return True

    def _report(self, text: str | None) -> None:
        if text is not None:
            self._rare.warning(f"{self._url} reports: {text}")

    async def _log_is_read(self) -> bool:
        """Return whether a line of ours has come back from the log, after waiting for it."""
        try:
            async with asyncio.timeout(LOG_WAIT_S):
                return await self._reads_log.wait()
        except TimeoutError:
            return False

    async def _send(self, operations: Iterable[dict[str, Any]]) -> None:
        for operation in operations:
            await self._connection.send(to_json(operation))
