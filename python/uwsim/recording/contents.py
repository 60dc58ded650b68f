"""Reads a recording's contents except its messages, and verifies all checksums, indexes and counts.

A finished file has a checksum over all its bytes. A file whose writer was killed lacks it, but each chunk and
attachment has a checksum, and the header contains the checksum of the leading metadata, so any corrupted bit is
detected in either case. Files rewritten by other tools, such as `mcap filter`, are verified against the checksums and
indexes that they contain.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Header,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
)

from uwsim.recording.commands import COMMANDS
from uwsim.recording.mcap_sink import LIBRARY, PROFILE, START
from uwsim.recording.records import FIRST, HEAD_BYTES, Message, Record, RecordFile, in_chunk, unpacked

WRONG_CHECKSUM = "its checksum is wrong"
SEQUENCES = 1 << 32
"""Messages of a channel are numbered up to this value, then again from 0."""
INDEXES: dict[int, str] = {
    Opcode.CHUNK_INDEX: "chunk",
    Opcode.ATTACHMENT_INDEX: "attachment",
    Opcode.METADATA_INDEX: "metadata",
}
"""The kinds of records in the index at the end, and what they list."""


class ChunkPlace(NamedTuple):
    """A chunk of a file. checksum: CRC-32 of the record's content.

    channels: the channels with messages in the chunk.
    """

    number: int
    start: int
    length: int
    checksum: int
    channels: frozenset[int]


@dataclass
class Contents:
    """The contents of a file except its messages. metadata, attachments: keyed by name.

    schemas, channels: keyed by number. counts: number of messages per channel. indexes: the expected index at the end,
    by kind of record. is_ours: whether uwsim wrote the file itself. is_whole: whether the data are complete; complete:
    whether the index is also complete.
    """

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    chunks: list[ChunkPlace] = field(default_factory=list)
    indexes: dict[int, list[Any]] = field(default_factory=lambda: {kind: [] for kind in INDEXES})
    is_ours: bool = False
    is_whole: bool = False
    complete: bool = False

    def announce(self, record: Channel | Schema) -> None:
        """Add a channel or schema. Raises ValueError if its number is already used for a different one."""
        known: dict[int, Any] = self.channels if isinstance(record, Channel) else self.schemas
        if known.setdefault(record.id, record) != record:
            raise ValueError(f"its {type(record).__name__.lower()} {record.id} differs from an earlier one")


def read_messages(path: Path, chunks: Sequence[ChunkPlace]) -> Iterator[Message]:
    """Yield the messages in chunks. Raises ValueError if a chunk has changed since it was first read, or OSError."""
    with path.open("rb") as file:
        for chunk in chunks:
            file.seek(chunk.start)
            record = Record(Opcode.CHUNK, chunk.number, chunk.start, file.read(chunk.length)[HEAD_BYTES:])
            if zlib.crc32(record.content) != chunk.checksum:
                raise ValueError(f"recording '{path}': {record.place}: has changed since the file was opened")
            for part in in_chunk(unpacked(record.parsed())):
                if isinstance(part, Message):
                    yield part


class DataReader:
    """Reads and validates the records up to the end of the data, filling in `contents`."""

    def __init__(self, file: RecordFile) -> None:
        self.contents = Contents()
        self._file = file
        self._start_checksum: int | None = None  # checksum of the leading metadata, from the header
        self._index: dict[int, list[tuple[int, int]]] = {}  # expected index of messages in the last chunk, by channel
        self._sequences: dict[int, int] = {}  # sequence number of the last message on each channel
        self._before = 0  # checksum of everything before the current record
        self._add: dict[int, Callable[[Record, Any], None]] = {
            Opcode.HEADER: self._add_header,
            Opcode.METADATA: self._add_metadata,
            Opcode.ATTACHMENT: self._add_attachment,
            Opcode.CHUNK: self._add_chunk,
            Opcode.MESSAGE_INDEX: self._add_message_index,
            Opcode.DATA_END: self._add_end,
        }

    def read(self) -> None:
        """Read all records. Raises CutOffError or ValueError."""
        while not self.contents.is_whole:
            self._before = self._file.checksum
            record = self._file.record()
            with record.named(self._file):
                if record.kind not in self._add or (record.kind == Opcode.HEADER) != (record.start == FIRST):
                    raise ValueError("it is out of place")
                if record.kind != Opcode.MESSAGE_INDEX:
                    self._require_indexed()
                self._add[record.kind](record, record.parsed())

    def _add_header(self, record: Record, header: Header) -> None:
        found = LIBRARY.fullmatch(header.library)
        if found is None:
            return
        if header.profile != PROFILE:
            raise ValueError(f"its profile is {header.profile!r}, not {PROFILE!r}")
        self.contents.is_ours = True
        self._start_checksum = int(found[1], 16)

    def _add_metadata(self, record: Record, metadata: Metadata) -> None:
        if metadata.name in self.contents.metadata:
            raise ValueError(f"'{metadata.name}' occurs twice")
        if metadata.name == START and self._start_checksum not in (None, zlib.crc32(record.content)):
            raise ValueError(WRONG_CHECKSUM)
        self.contents.metadata[metadata.name] = metadata.metadata
        self._list(MetadataIndex(record.start, record.length, metadata.name), Opcode.METADATA_INDEX)

    def _add_attachment(self, record: Record, attachment: Attachment) -> None:
        name, data = attachment.name, attachment.data
        if name in self.contents.attachments:
            raise ValueError(f"'{name}' occurs twice")
        self._compare(int.from_bytes(record.content[-4:], "little"), zlib.crc32(record.content[:-4]))
        self.contents.attachments[name] = data
        index = AttachmentIndex(
            offset=record.start, length=record.length, log_time=attachment.log_time,
            create_time=attachment.create_time, data_size=len(data), name=name, media_type=attachment.media_type,
        )  # fmt: skip
        self._list(index, Opcode.ATTACHMENT_INDEX)

    def _add_chunk(self, record: Record, chunk: Chunk) -> None:
        data = unpacked(chunk)
        self._compare(chunk.uncompressed_crc, zlib.crc32(data))
        self._index = {}
        for part in in_chunk(data):
            if isinstance(part, Message):
                self._require_in_turn(part)
                self._index.setdefault(part.channel_id, []).append((part.time_ns, part.offset))
            else:
                self.contents.announce(part)
        times_ns = [time_ns for entries in self._index.values() for time_ns, _ in entries]
        if (min(times_ns, default=0), max(times_ns, default=0)) != (chunk.message_start_time, chunk.message_end_time):
            raise ValueError("its times do not match its messages")
        self.contents.counts.update({channel: len(entries) for channel, entries in self._index.items()})
        checksum, channels = zlib.crc32(record.content), frozenset(self._index)
        self.contents.chunks.append(ChunkPlace(record.number, record.start, record.length, checksum, channels))
        index = ChunkIndex(
            chunk_length=record.length,
            chunk_start_offset=record.start,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=chunk.message_start_time,
            uncompressed_size=chunk.uncompressed_size,
        )
        self._list(index, Opcode.CHUNK_INDEX)

    def _add_message_index(self, record: Record, index: MessageIndex) -> None:
        chunks = self.contents.indexes[Opcode.CHUNK_INDEX]
        if not chunks or index.channel_id in chunks[-1].message_index_offsets:
            raise ValueError("it is out of place")
        if sorted(index.records) != sorted(self._index.get(index.channel_id, [])):
            raise ValueError(f"it is not that of chunk {len(chunks)}")
        chunks[-1].message_index_offsets[index.channel_id] = record.start
        chunks[-1].message_index_length += record.length

    def _add_end(self, record: Record, end: DataEnd) -> None:
        if end.data_section_crc != self._before and (end.data_section_crc or self.contents.is_ours):
            raise ValueError("the checksum of all data is wrong")
        self.contents.is_whole = True

    def _require_indexed(self) -> None:
        """Raise ValueError if an index of messages in the last chunk is missing."""
        chunks = self.contents.indexes[Opcode.CHUNK_INDEX]
        if self.contents.is_ours and chunks and set(chunks[-1].message_index_offsets) != set(self._index):
            raise ValueError(f"before it, an index of chunk {len(chunks)} is missing")

    def _require_in_turn(self, message: Message) -> None:
        """Raise ValueError for a message that has no channel or is out of sequence on its channel."""
        channel = self.contents.channels.get(message.channel_id)
        if channel is None:
            raise ValueError(f"it has a message of channel {message.channel_id}, which does not exist")
        if not self.contents.is_ours:
            return  # other tools may reorder or leave out messages
        last = self._sequences.get(message.channel_id, -1)
        ahead = (message.sequence - last) % SEQUENCES
        if not 0 < ahead < SEQUENCES // 2:
            raise ValueError(f"a message of {channel.topic} occurs twice, or out of order")
        if ahead > 1 and channel.topic == f"/{COMMANDS}":  # commands are never dropped
            raise ValueError(f"before it, {ahead - 1} commands are missing")
        self._sequences[message.channel_id] = message.sequence

    def _compare(self, given: int, found: int) -> None:
        """Raise ValueError if a checksum differs from the stored one.

        Other tools may store 0, which means no checksum.
        """
        if given != found and (given or self.contents.is_ours):
            raise ValueError(WRONG_CHECKSUM)

    def _list(self, index: Any, kind: Opcode) -> None:
        self.contents.indexes[kind].append(index)
