"""Recording: what a file says, message by message, also if the run was killed while it wrote."""

from __future__ import annotations

import json
import struct
from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, Footer, Message, Metadata, Schema
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk

from uwsim.channels.messages import from_bytes
from uwsim.recording import tables
from uwsim.recording.commands import COMMANDS, Command, command_of
from uwsim.recording.mcap_sink import END, START

if TYPE_CHECKING:
    import pandas
    import pyarrow
    import xarray

DAMAGED = (McapError, CRCValidationError, struct.error, RuntimeError, UnicodeDecodeError, EOFError)
"""What reading a file that ends in the middle of a record raises; RuntimeError is lz4's."""


class ChannelInfo(NamedTuple):
    """A channel of a recording: name without leading slash, type in ROS 2's spelling, number of messages."""

    name: str
    type: str
    message_count: int
    rate_hz: float | None


class Recorded(NamedTuple):
    """One message. time_ns: simulated. data: in CDR."""

    topic: str
    type: str
    time_ns: int
    data: bytes

    @property
    def message(self) -> Any:
        """The message itself."""
        return from_bytes(self.data, self.type)


class Recording:
    """A recording that was written by a Recorder, from .mcap.

    start, end: the metadata at both ends; end is empty if the recording was killed. complete: whether it ended in
    order. attachments: by name.
    """

    def __init__(self, path: str | Path) -> None:
        """Read everything but the messages. Raises ValueError for a file that is no recording, OSError."""
        self.path = Path(path)
        self.start: dict[str, str] = {}
        self.end: dict[str, str] = {}
        self.attachments: dict[str, bytes] = {}
        self.complete = False
        self._channels: dict[int, Channel] = {}
        self._schemas: dict[int, Schema] = {}
        self._counts: dict[int, int] = {}
        if self.path.suffix == ".bag":
            raise ValueError(f"recording '{path}': a bag of ROS 1 cannot be read here; record .mcap instead")
        with self.path.open("rb") as file:
            self._read_frame(file)
        if not self.start:
            raise ValueError(f"recording '{path}': was not written by uwsim, or holds nothing yet")

    @cached_property
    def channels(self) -> dict[str, ChannelInfo]:
        """The channels by name."""
        found = {}
        for number, channel in self._channels.items():
            name = channel.topic.removeprefix("/")
            rate = channel.metadata.get("rate_hz") or None
            kind = self._schemas[channel.schema_id].name
            count = self._counts.get(number, 0)
            found[name] = ChannelInfo(name, kind, count, None if rate is None else float(rate))
        return found

    def metadata(self, topic: str) -> dict[str, str]:
        """Return what the file says about a channel: QoS, type hash, rate, description. Raises ValueError."""
        (number,) = self._numbers((topic,))
        return dict(self._channels[number].metadata)

    @property
    def step_ns(self) -> int:
        """The length of a step."""
        return round(float(self.start["step_s"]) * 1e9)

    @property
    def dropped(self) -> dict[str, int]:
        """How many messages of each channel were left out because writing was too slow."""
        return dict(json.loads(self.end.get("dropped", "{}")))

    @property
    def notes(self) -> dict[str, Any]:
        """Values that belong to the whole run; those that are known at its end are missing if it was cut off."""
        return dict(json.loads(self.end.get("notes", self.start.get("notes", "{}"))))

    def messages(self, *topics: str) -> Iterator[Recorded]:
        """Yield the messages in the order in which they were recorded; of these topics, by default of all.

        Raises ValueError for a topic that was not recorded.
        """
        wanted = self._numbers(topics)
        with self.path.open("rb") as file:
            for chunk in _records(file, chunks=True):
                if not isinstance(chunk, Chunk):
                    continue
                for record in breakup_chunk(chunk):
                    if isinstance(record, Message) and record.channel_id in wanted:
                        yield self._recorded(record)

    def commands(self) -> Iterator[Command]:
        """Yield the commands in the order in which they took effect."""
        for recorded in self.messages(COMMANDS):
            yield command_of(recorded.message)

    def arrow(self, topic: str) -> pyarrow.Table:
        """Return a channel as an Arrow table; see uwsim.recording.tables."""
        return tables.arrow(self, self._named(topic))

    def pandas(self, topic: str) -> pandas.DataFrame:
        """Return a channel as a pandas DataFrame by simulated seconds; see uwsim.recording.tables."""
        return tables.pandas_frame(self, self._named(topic))

    def xarray(self, topic: str) -> xarray.Dataset:
        """Return a channel as an xarray Dataset, with arrays as arrays; see uwsim.recording.tables."""
        return tables.dataset(self, self._named(topic))

    def _named(self, topic: str) -> str:
        self._numbers((topic,))
        return topic.removeprefix("/")

    def _recorded(self, record: Message) -> Recorded:
        channel = self._channels[record.channel_id]
        kind = self._schemas[channel.schema_id].name
        return Recorded(channel.topic.removeprefix("/"), kind, record.log_time, record.data)

    def _numbers(self, topics: Collection[str]) -> set[int]:
        numbers = {channel.topic.removeprefix("/"): number for number, channel in self._channels.items()}
        for topic in topics:
            if topic.removeprefix("/") not in numbers:
                raise ValueError(f"recording '{self.path}': topic '{topic}': must be one of {', '.join(numbers)}")
        return {numbers[topic.removeprefix("/")] for topic in topics} if topics else set(numbers.values())

    def _read_frame(self, file: IO[bytes]) -> None:
        """Read channels, counts, metadata and attachments."""
        for record in _records(file):
            if isinstance(record, Channel):
                self._channels.setdefault(record.id, record)
            elif isinstance(record, Schema):
                self._schemas.setdefault(record.id, record)
            elif isinstance(record, Message):
                self._counts[record.channel_id] = self._counts.get(record.channel_id, 0) + 1
            elif isinstance(record, Attachment):
                self.attachments[record.name] = record.data
            elif isinstance(record, Metadata):
                self.start = record.metadata if record.name == START else self.start
                self.end = record.metadata if record.name == END else self.end
            elif isinstance(record, Footer):
                self.complete = True


def _records(file: IO[bytes], *, chunks: bool = False) -> Iterator[Any]:
    """Yield the records of a file up to its end, or to where it is cut off. chunks: do not take them apart."""
    try:
        for record in StreamReader(file, emit_chunks=True, validate_crcs=False).records:
            if isinstance(record, Chunk):
                parts = breakup_chunk(record, validate_crc=True)  # also finds out whether it is whole
                if not chunks:
                    yield from parts
                    continue
            yield record
    except DAMAGED:
        return
