"""Writes a recording as a ROS 1 bag, with the `rosbags` library; Debian's rosbag can read it."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Writer

from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading
from uwsim.channels.ros.message_types import ros1_typestore
from uwsim.channels.ros.messages import numbered, to_bytes
from uwsim.recording.sink import Batch


class BagSink:
    """A .bag file. It has no attachments, and no index until it is closed. `rosbag reindex` can add the index."""

    def __init__(self, path: Path, *, compressed: bool = True) -> None:
        """Create the file. Raises OSError if it exists or cannot be written.

        compressed: whether chunks are compressed, which gains nothing for PNG pictures.
        """
        if path.exists():
            raise FileExistsError(17, "File exists")
        self._writer = Writer(path)
        if compressed:  # Debian's rosbag rejects the LZ4 written by rosbags
            self._writer.set_compression(Writer.CompressionFormat.BZ2)
        self._writer.open()
        self._connections: dict[str, Connection] = {}

    def encode(self, reading: Reading) -> bytes:
        """Return a message in ROS 1 serialization."""
        return to_bytes(reading.message, ros=1)

    def add_channel(self, channel: Channel) -> None:
        """Register a channel before its first message."""
        self._connections[channel.name] = self._writer.add_connection(
            "/" + channel.name,
            channel.type,
            typestore=ros1_typestore(),
            callerid="/uwsim",
            latching=int(channel.delivery.latched),
        )

    def write(self, messages: Batch) -> None:
        """Append messages, each with its number as header.seq.

        Time 0 is written as 1 ns, since time 0 means "no time" in ROS 1.
        """
        connections = [self._connections[topic] for topic in messages.topics]
        for which, time_ns, sequence, data in zip(
            *(part.tolist() for part in messages[1:4]), messages.data, strict=True
        ):
            connection = connections[which]
            self._writer.write(connection, max(time_ns, 1), numbered(data, connection.msgtype, sequence))

    def flush(self) -> None:
        """Do nothing, since chunks are written as they fill up."""

    def close(self, end: Mapping[str, str]) -> None:
        """Write the index and close the file. Raises OSError."""
        try:
            self._writer.close()
        except BaseException:
            with contextlib.suppress(Exception):
                self._writer.abort()
            raise

    def abandon(self) -> None:
        """Close after a write error, with an index if there is space for it."""
        with contextlib.suppress(Exception):
            self.close({})
