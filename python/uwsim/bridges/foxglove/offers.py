"""Offers: the numbered topics and their subscribers. The topics are the simulator's channels, in CDR, and scenes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from foxglove.messages import SceneUpdate

from uwsim.bridges.bridge import Bridge
from uwsim.bridges.foxglove.outbox import Outbox
from uwsim.bridges.foxglove.protocol import Offer
from uwsim.bridges.foxglove.shows import Show
from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading
from uwsim.channels.delivery.outgoing import Job, Line, Outgoing, queue_of
from uwsim.channels.ros.cdr import schema

Sinks = tuple[tuple[Outbox, int], ...]
"""Subscribed clients' outboxes, each with the number that the client chose for its subscription."""


class Offers:
    """The topics, keyed by number. All methods except `send` and `queue` are called on the network thread."""

    def __init__(self, bridge: Bridge, outgoing: Outgoing) -> None:
        self._bridge, self._outgoing = bridge, outgoing
        self._channels = bridge.outputs
        self._shows: dict[str, Show] = {}
        self._lines: dict[str, Line[Job]] = {
            name: Line(name, queue_of(channel.type), channel.drops) for name, channel in self._channels.items()
        }
        self._sinks: dict[str, Sinks] = {}  # values are replaced as a whole, since another thread reads them
        self.offers: list[Offer] = []

    def complete(self, shows: Sequence[Show]) -> None:
        """Add the scenes, and number all topics."""
        self._shows = {show.topic: show for show in shows}
        found = [_of_channel(number, one) for number, one in enumerate(self._channels.values(), start=1)]
        scene = SceneUpdate.get_schema()
        for number, topic in enumerate(self._shows, start=len(found) + 1):
            found.append(Offer(number, topic, "protobuf", scene.name, scene.encoding, scene.data))
        self.offers = found

    def subscribe(self, offer_id: int, outbox: Outbox, number: int) -> None:
        """Start sending a topic to a client. A late subscriber to a latched topic receives the latest message."""
        name = self._name(offer_id)
        before = self._sinks.get(name, ())
        self._sinks[name] = (*before, (outbox, number))
        try:
            if name in self._shows:
                self._shows[name].begin(lambda time_ns, data: outbox.put((number, time_ns, data), builds_up=True))
            elif not before:
                self._bridge.listen(name)
            elif self._channels[name].delivery.latched:
                self._outgoing.offer(Line(name, 1), partial(self._catch_up, name, outbox, number))
        except Exception:
            self.unsubscribe(offer_id, outbox)
            raise

    def unsubscribe(self, offer_id: int, outbox: Outbox) -> None:
        """Stop sending a topic to a client. Topics without subscribers are no longer read."""
        name = self._name(offer_id)
        left = tuple(sink for sink in self._sinks.get(name, ()) if sink[0] is not outbox)
        self._sinks[name] = left
        if not left and name in self._shows:
            self._shows[name].end()
        elif not left:
            self._bridge.leave(name)

    def close(self) -> None:
        """Stop producing scenes."""
        for show in self._shows.values():
            show.end()

    def send(self, name: str, time_ns: int, data: bytes) -> None:
        """Queue a message for all subscribers to its topic. May be called on any thread."""
        builds_up = name in self._shows
        for outbox, number in self._sinks.get(name, ()):
            outbox.put((number, time_ns, data), builds_up=builds_up)

    def _name(self, offer_id: int) -> str:
        if not 1 <= offer_id <= len(self.offers):
            raise ValueError(f"channel {offer_id}: does not exist")
        return self.offers[offer_id - 1].name

    def queue(self, reading: Reading) -> None:
        """Queue a reading, on the simulator's thread, to be encoded on another thread."""
        name = reading.channel.name

        def write() -> bool:
            self.send(name, reading.time_ns, bytes(reading.cdr))
            return True

        self._outgoing.offer(self._lines[name], write)

    def _catch_up(self, name: str, outbox: Outbox, number: int) -> bool:
        newest = self._bridge.feed.newest(self._channels[name])
        if newest is not None:
            outbox.put((number, newest.time_ns, bytes(newest.cdr)))
        return newest is not None


def _of_channel(number: int, channel: Channel) -> Offer:
    found = schema(channel.type)
    metadata = {"type_hash": found.type_hash, "description": channel.description}
    return Offer(number, channel.name, "cdr", channel.type, "ros2msg", found.text.encode(), metadata)
