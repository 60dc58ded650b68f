"""KeptConnection: a thread that connects to another system, again whenever it is lost, and sends what waits."""

from __future__ import annotations

import selectors
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Iterable
from contextlib import suppress
from logging import Logger
from typing import ClassVar, Generic, Self, TypeVar

from uwsim.bridges.doors.waiting import Waiting
from uwsim.bridges.rare_log import RareLog

CONNECT_S, AGAIN_S = 5.0, 1.0
"""Time to connect, and between attempts."""
WAITING_MAX = 10_000
"""Messages that wait to be sent; older ones are dropped."""
READ_BYTES = 1 << 16
UNSENT_BYTES = 16 * READ_BYTES
"""Bytes that a peer has not read, after which it is given up."""
DATAGRAMS_MAX = 64
"""Datagrams that are read at once, so that no sender keeps the thread from sending."""
MessageT = TypeVar("MessageT")


class KeptConnection(ABC, Generic[MessageT]):
    """The base of a bridge's connection. Its messages wait in a queue, which wakes the thread.

    failure: the protocol's exception; it ends a connection with a line in the log, as an OSError does. where: the
    peer, as the log names it.
    """

    failure: ClassVar[type[Exception]] = OSError

    def __init__(self, where: str, log: Logger, thread: str) -> None:
        self._where_it_is, self._log, self._rare = where, log, RareLog(log)
        self._waiting = Waiting[MessageT](WAITING_MAX)
        self._wake, self._woken = socket.socketpair()
        self._wake.setblocking(False)
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name=thread, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Close."""
        self._is_closed = True
        self._wake_up()
        self._thread.join(CONNECT_S + AGAIN_S)
        self._wake.close()
        self._woken.close()

    @abstractmethod
    def _converse(self) -> None:
        """Connect and exchange messages until closed. Raises OSError or `failure` when the connection ends."""

    def _forget(self) -> None:
        """Forget what was known about the peer, after a connection."""

    def _queue(self, messages: Iterable[MessageT]) -> None:
        """Queue messages and wake the thread. Does not block; may be called on any thread."""
        for message in messages:
            self._waiting.put(message)
        self._wake_up()

    def _taken(self) -> list[MessageT]:
        """Return the messages that wait, which then no longer do."""
        return list(iter(self._waiting.take, None))

    def _wake_up(self) -> None:
        with suppress(OSError):  # it is awake, or closed
            self._wake.send(b"\0")

    def _run(self) -> None:
        while not self._is_closed:
            try:
                self._converse()
            except self.failure as error:
                self._rare.warning(f"{self._where_it_is}: {error}")
            except OSError as error:
                self._rare.warning(f"{self._where_it_is}: {error.strerror or error}; trying again")
            except Exception:  # of what is called with messages
                self._log.exception("%s: a message could not be handled", self._where_it_is)
            self._forget()
            self._waiting.clear()
            until_s = time.monotonic() + AGAIN_S
            while not self._is_closed and time.monotonic() < until_s:
                time.sleep(0.05)


class Stream:
    """A TCP connection that never blocks: what its peer does not read yet is kept. woken: ends a wait."""

    def __init__(self, connection: socket.socket, woken: socket.socket) -> None:
        connection.settimeout(0.0)
        self._connection, self._woken, self._unsent = connection, woken, bytearray()
        self._selector = selectors.DefaultSelector()
        for each in (connection, woken):
            self._selector.register(each, selectors.EVENT_READ)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._selector.close()

    def send(self, packets: Iterable[bytes]) -> None:
        """Send packets, or keep what cannot be sent yet. Raises OSError for a peer that does not read."""
        self._unsent += b"".join(packets)
        if len(self._unsent) > UNSENT_BYTES:
            raise OSError("does not read what it is sent")
        with suppress(BlockingIOError):
            while self._unsent:
                del self._unsent[: self._connection.send(self._unsent)]
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if self._unsent else 0)
        self._selector.modify(self._connection, events)

    def wait(self, wait_s: float) -> None:
        """Wait until there is something to read or send, at most wait_s."""
        for key, _ in self._selector.select(wait_s):
            if key.fileobj is self._woken:
                self._woken.recv(READ_BYTES)

    def received(self) -> list[bytes]:
        """Return what has arrived; empty if nothing has. Raises OSError if the peer has closed the connection."""
        with suppress(BlockingIOError):
            data = self._connection.recv(READ_BYTES)
            if not data:
                raise OSError("has closed the connection")
            return [data]
        return []


class Datagrams(Stream):
    """The same for datagrams, which may be lost."""

    def send(self, packets: Iterable[bytes]) -> None:
        """Send each as a datagram."""
        for packet in packets:
            with suppress(OSError):  # no program listens there
                self._connection.send(packet)

    def received(self) -> list[bytes]:
        """Return the datagrams that have arrived, at most DATAGRAMS_MAX at once."""
        found: list[bytes] = []
        with suppress(BlockingIOError, ConnectionRefusedError):  # the second: no program listens there
            while len(found) < DATAGRAMS_MAX:
                found.append(self._connection.recv(READ_BYTES))
        return found
