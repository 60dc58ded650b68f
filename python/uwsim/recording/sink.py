"""What a recording is written to: one interface for the formats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from uwsim.channels import Channel
from uwsim.channels.feed import Reading


class Sink(Protocol):
    """A file that takes messages. All calls but `encode` come from one thread at a time."""

    def encode(self, reading: Reading) -> bytes | memoryview:
        """Return a message in the format's bytes."""

    def add_channel(self, channel: Channel) -> None:
        """Announce a channel, before its first message."""

    def write(self, topic: str, time_ns: int, sequence: int, data: bytes | memoryview) -> None:
        """Append a message, in simulated time. Raises OSError."""

    def flush(self) -> None:
        """Hand what was written so far to the operating system, so that it survives this process. Raises OSError."""

    def close(self, end: Mapping[str, str]) -> None:
        """Write what belongs at the end, and close. Raises OSError."""

    def abandon(self) -> None:
        """Close after an error of writing, and keep what can be read."""
