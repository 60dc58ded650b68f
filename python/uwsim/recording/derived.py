"""Generates messages that can be derived from a survey's pings, and are therefore not recorded."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from typing import TYPE_CHECKING, Any

from uwsim.channels import Channel
from uwsim.channels.channel import LATCHED
from uwsim.channels.families.map import insert_ping
from uwsim.channels.families.map_changes import MapChanges
from uwsim.channels.families.pings import TakenPing
from uwsim.channels.families.scans import DEPTH_ARRAY, PING_TOPICS, PingTopic
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import MAP_CHANGES
from uwsim.mapping import ranging
from uwsim.recording.head import RecordedHead, recorded_head
from uwsim.recording.pings import NAME

if TYPE_CHECKING:
    from uwsim.recording.messages import Messages

MAP_TOPIC = "map_changes"
FROM_PINGS = frozenset({*(topic.name for topic in PING_TOPICS), MAP_TOPIC})
"""The names of these topics without the vehicle's prefix."""

Make = Callable[[TakenPing], Any]
"""Returns the message for a ping; must be called with all pings in order."""


class Derived:
    """The topics of a survey recording that are derived from its pings, each with one message per ping.

    The map is the map that a live run would build from these pings. channels: keyed by name.
    """

    def __init__(self, recording: Messages) -> None:
        """Load the multibeam from the recording's scenario. Raises ValueError or OSError."""
        self._head = head = recorded_head(recording, NAME)
        rate_hz = recording.channels[NAME].rate_hz
        self.channels: dict[str, Channel] = {}
        self._begin: dict[str, Callable[[], Make]] = {}
        for topic in PING_TOPICS:
            if topic is DEPTH_ARRAY and head.model.number not in ranging.MODELS:
                continue
            self._offer(
                Channel(head.prefix + topic.name, topic.type, "out", f"{topic.description}; once a ping", rate_hz),
                partial(_of_ping, head, topic),
            )
        about = "the voxels that became occupied or unoccupied with each ping"
        self._offer(
            Channel(head.prefix + MAP_TOPIC, MAP_CHANGES, "out", about, rate_hz, delivery=LATCHED),
            partial(_of_map, head),
        )

    def makers(self, names: Collection[str]) -> dict[str, Make]:
        """Return functions that generate the messages of some topics, starting with the first ping."""
        return {name: self._begin[name]() for name in names}

    def _offer(self, channel: Channel, begin: Callable[[], Make]) -> None:
        self.channels[channel.name] = channel
        self._begin[channel.name] = begin


def _of_ping(head: RecordedHead, topic: PingTopic) -> Make:
    frame_id = head.prefix + topic.frame if topic.frame else ""
    return lambda taken: topic.make(head, taken, frame_id)


def _of_map(head: RecordedHead) -> Make:
    occupancy, changes = head.new_map(), MapChanges()
    changes.forget(occupancy.resolution_m)

    def make(taken: TakenPing) -> Any:
        insert_ping(occupancy, head, taken)
        part = changes.note(occupancy.changed_occupancy())
        header = build.header(taken.ping.time_ns, head.prefix + "odom")
        return build.message(MAP_CHANGES, header=header, **part._asdict())

    return make
