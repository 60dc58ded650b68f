"""The parts of a ROS 2 middleware that the node uses, implemented by `dds_transport` and `zenoh_transport`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

DEPTH = 10  # number of messages by which a reader may lag; the ROS 2 default


class Writer(Protocol):
    """Writes CDR to a topic."""

    def write(self, cdr: memoryview) -> bool:
        """Write a message; return whether it was accepted."""

    def readers(self) -> int:
        """Return the number of matching readers, and clear the event that reported a change."""

    def has_best_effort_readers(self) -> bool:
        """Return whether any matching reader loses what does not fit into its socket's buffer."""


class Reader(Protocol):
    """Reads CDR from a topic."""

    def take(self, limit: int) -> list[bytes]:
        """Return up to `limit` messages that have arrived."""

    def writers(self) -> int:
        """Return the number of matching writers, and clear the event that reported a change."""


class Call(NamedTuple):
    """A call. request: in CDR. reply: sends the response in CDR."""

    request: bytes
    reply: Callable[[memoryview], bool]


class Server(Protocol):
    """Receives the calls of a service."""

    def take(self, limit: int) -> list[Call]:
        """Return up to `limit` calls that have arrived."""


class Events(Protocol):
    """Waits for messages and calls, and for readers and writers to appear or disappear."""

    def attach(self, source: Writer | Reader | Server) -> None:
        """Add a source to wait for."""

    def wait(self, timeout_s: float) -> Sequence[Writer | Reader | Server]:
        """Wait for events; return their sources, or none after a timeout or `wake`."""

    def wake(self) -> None:
        """End a wait, from any thread."""


class Transport(Protocol):
    """A connection to a ROS 2 graph. Names of topics and services have no leading slash."""

    def writer(self, topic: str, type_name: str, depth: int, *, latched: bool) -> Writer:
        """Return a new writer."""

    def reader(self, topic: str, type_name: str, *, reliable: bool) -> Reader:
        """Return a new reader."""

    def server(self, name: str, type_name: str) -> Server:
        """Return a new server of a service."""

    def wait_set(self) -> Events:
        """Return an object that waits for events from all readers, writers and servers."""

    def announce(self) -> None:
        """Make the node and its endpoints known."""

    def close(self) -> None:
        """Leave the graph; other nodes are notified."""
