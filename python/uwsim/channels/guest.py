"""Peers of a graph that are no simulator and outlive one, such as the operator's station."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Protocol

Values = dict[str, Any]
CatchUp = Callable[[Any], tuple[Any, Any]]


@dataclass(frozen=True)
class GuestTopic:
    """A topic that a guest publishes. latched: a late subscriber gets the newest message at once."""

    name: str
    type: str
    description: str = ""
    latched: bool = False


@dataclass(frozen=True)
class GuestService:
    """A service. call: with the caller's name and the request; returns the response, or a Future of it; ValueError.

    is_brief: it is called on the network's thread, which it must not keep waiting.
    """

    name: str
    type: str
    call: Callable[[str, Values], Values | Future[Values]]
    description: str = ""
    is_brief: bool = False


class Node(Protocol):
    """A guest's end of the graph; all may be called on any thread."""

    def publish(self, name: str, message: Any, time_ns: int = 0, catch_up: CatchUp | None = None) -> None:
        """Publish a message on a topic that is offered. catch_up: as a Channel's, of messages that build up."""

    def offer_topics(self, topics: Iterable[GuestTopic]) -> None:
        """Offer these topics, instead of those before."""

    def is_wanted(self, name: str) -> bool:
        """Return whether a topic has subscribers."""

    def is_awaited(self, name: str) -> bool:
        """Return whether a subscriber was ready for the last message of a topic, or there has been none."""

    def silence_s(self, client: str) -> float:
        """Return for how long [s] nothing at all has come from a client, answers to pings included."""


class Guest(Protocol):
    """What takes part in a graph under a name."""

    @property
    def name(self) -> str:
        """Its name in the graph, "/station"."""

    @property
    def services(self) -> Sequence[GuestService]:
        """What it offers."""

    def connect(self, node: Node) -> None:
        """Take its node, once."""

    def demanded(self) -> None:
        """Take note, on the network's thread, that a topic has got its first subscriber."""

    def left(self, client: str) -> None:
        """Take note, on the network's thread, that a client has gone."""
