"""Guests: participants in a graph, such as the operator's station, that may outlive simulators."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Protocol

Values = dict[str, Any]
CatchUp = Callable[[Any], tuple[Any, Any]]


@dataclass(frozen=True)
class GuestTopic:
    """A topic that a guest publishes. latched: whether late subscribers receive the latest message immediately."""

    name: str
    type: str
    description: str = ""
    latched: bool = False


@dataclass(frozen=True)
class GuestService:
    """A service that a guest offers.

    call: receives the caller's name and the request, and returns the response or a Future of it. It may raise
    ValueError. is_brief: whether `call` runs on the network thread, which it must not block. fields: the names of the
    request's fields, in order.
    """

    name: str
    type: str
    call: Callable[[str, Values], Values | Future[Values]]
    description: str = ""
    is_brief: bool = False
    fields: tuple[str, ...] = ()


class Node(Protocol):
    """A guest's end of the graph; all methods may be called on any thread."""

    def publish(self, name: str, message: Any, time_ns: int = 0, catch_up: CatchUp | None = None) -> None:
        """Publish a message on an offered topic. catch_up: as in Channel, for messages that build on each other."""

    def offer_topics(self, topics: Iterable[GuestTopic]) -> None:
        """Offer these topics, replacing the previous ones."""

    def is_wanted(self, name: str) -> bool:
        """Return whether a topic has subscribers."""

    def is_awaited(self, name: str) -> bool:
        """Return True if a subscriber was ready for a topic's last message, or if there has been no message yet."""

    def silence_s(self, client: str) -> float:
        """Return the time [s] since anything, including a ping reply, was last received from a client."""


class Guest(Protocol):
    """A participant in a graph, to which it connects through a Node."""

    @property
    def name(self) -> str:
        """The guest's name in the graph, such as "/station"."""

    @property
    def services(self) -> Sequence[GuestService]:
        """The services that the guest offers."""

    def connect(self, node: Node) -> None:
        """Called once, with the guest's node."""

    def demanded(self) -> None:
        """Called on the network thread when a topic gets its first subscriber."""

    def left(self, client: str) -> None:
        """Called on the network thread when a client has disconnected."""
