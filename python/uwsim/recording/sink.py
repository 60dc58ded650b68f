"""The destination of a recording, with a common interface for all formats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading

Data = bytes | memoryview
Item = tuple[str, int, int, Data]
"""A message: topic, time [ns], sequence number, data."""


class Batch(NamedTuple):
    """Messages in order.

    which: (n,), the place of each one's topic among `topics`. times_ns, sequences, data: n each.
    """

    topics: Sequence[str]
    which: NDArray[np.intp]
    times_ns: NDArray[np.int64]
    sequences: NDArray[np.int64]
    data: Sequence[Data]

    @classmethod
    def of(cls, items: Sequence[Item]) -> Batch:
        """Return the batch of some messages, at least one."""
        topics, times_ns, sequences, data = zip(*items, strict=True)
        places = {topic: place for place, topic in enumerate(dict.fromkeys(topics))}
        which = np.array([places[topic] for topic in topics])
        return cls(list(places), which, np.array(times_ns), np.array(sequences), data)


class Sink(Protocol):
    """A file that accepts messages. All methods except `encode` are called by one thread at a time."""

    def encode(self, reading: Reading) -> Data:
        """Return a message in the format's serialization."""

    def add_channel(self, channel: Channel) -> None:
        """Register a channel before its first message."""

    def write(self, messages: Batch) -> None:
        """Append messages, at least one, at their simulated times. Raises OSError."""

    def flush(self) -> None:
        """Pass all written data to the operating system, so that they are safe if the process is killed.

        Raises OSError.
        """

    def close(self, end: Mapping[str, str]) -> None:
        """Write the end of the file and close it. Raises OSError."""

    def abandon(self) -> None:
        """Close after a write error, keeping everything readable."""
