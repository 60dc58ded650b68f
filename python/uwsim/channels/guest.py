"""Peers of a graph other than simulators, which outlive them, such as the operator's station."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Protocol

Values = dict[str, Any]
CatchUp = Callable[[Any], tuple[Any, Any]]


@dataclass(frozen=True)
class GuestTopic:
    """A topic that a guest publishes. latched: a late subscriber gets the newest message immediately."""

    name: str
    type: str
    description: str = ""
    latched: bool = False


@dataclass(frozen=True)
class GuestService:
    """A service. call: with the caller's name and the request; returns the response, or a Future of it; ValueError.

    is_brief: it is called on the network thread, which it must not block.
    """

    name: str
    type: str
    call: Callable[[str, Values], Values | Future[Values]]
    description: str = ""
    is_brief: bool = False


class Node(Protocol):
    """A guest's end of the graph; all methods may be called on any thread."""

    def publish(self, name: str, message: Any, time_ns: int = 0, catch_up: CatchUp | None = None) -> None:
        """Publish a message on an offered topic. catch_up: as in Channel, for messages that build up."""

    def offer_topics(self, topics: Iterable[GuestTopic]) -> None:
        """Offer these topics, replacing the previous ones."""

    def is_wanted(self, name: str) -> bool:
        """Return whether a topic has subscribers."""

    def is_awaited(self, name: str) -> bool:
        """Return whether a subscriber was ready for the last message of a topic, or there has been none."""

    def silence_s(self, client: str) -> float:
        """Return how long [s] nothing has been received from a client, including answers to pings."""


class Guest(Protocol):
    """A participant in a graph under its own name."""

    @property
    def name(self) -> str:
        """Its name in the graph, "/station"."""

    @property
    def services(self) -> Sequence[GuestService]:
        """The services that it offers."""

    def connect(self, node: Node) -> None:
        """Receive its node; called once."""

    def demanded(self) -> None:
        """Called on the network thread when a topic has got its first subscriber."""

    def left(self, client: str) -> None:
        """Called on the network thread when a client has left."""
