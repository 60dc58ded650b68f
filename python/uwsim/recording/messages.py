"""Messages: the part of a Recording that tables, maps and derived channels read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from uwsim.channels.ros.messages import from_bytes


class ChannelInfo(NamedTuple):
    """Information about a channel. rate_hz: None for a single message."""

    name: str
    type: str
    message_count: int
    rate_hz: float | None


class Recorded(NamedTuple):
    """A recorded message. time_ns: simulated time. data: CDR bytes."""

    topic: str
    type: str
    time_ns: int
    data: bytes

    @property
    def message(self) -> Any:
        """The decoded message."""
        return from_bytes(self.data, self.type)


class Messages(Protocol):
    """A recording; see uwsim.recording.reader.Recording."""

    path: Path

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """The attachments by name."""

    @property
    def channels(self) -> dict[str, ChannelInfo]:
        """The recorded channels by name."""

    def info(self, topic: str) -> ChannelInfo:
        """Return information about a channel. Raises ValueError if it is unknown."""

    def messages(self, *topics: str) -> Iterator[Recorded]:
        """Yield the messages of these channels in order."""
