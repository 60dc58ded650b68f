"""Reads a recording's contents except its messages, by the records of the `mcap` library, and verifies all checksums.

A finished file has a checksum over all its bytes. A file whose writer was killed ends in the middle of a record and
lacks it, but each chunk and attachment has a checksum, and the header contains the checksum of the leading metadata.
Files rewritten by other tools, such as `mcap filter`, are verified against the checksums that they contain.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple

from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, Header, Message, MessageIndex, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from uwsim.base.texts.text_file import require_regular
from uwsim.recording.commands import COMMANDS
from uwsim.recording.mcap_file import RECORD_HEAD, UNREADABLE, in_chunk
from uwsim.recording.mcap_sink import LIBRARY, PROFILE, START

SEQUENCES = 1 << 32
"""Messages of a channel are numbered up to this value, then again from 0."""
DATA = (Opcode.HEADER, Opcode.METADATA, Opcode.ATTACHMENT, Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.DATA_END)
"""The kinds of records up to the end of the data; messages are in chunks, with the schemas and channels they need."""
PARSERS: dict[Opcode, Any] = {
    kind: getattr(records, kind.name.title().replace("_", "")) for kind in Opcode if kind != Opcode.MESSAGE
}
"""The library's readers, by kind of record."""
NOT_OURS = "was not written by uwsim"
"""In the message for a file of another's."""
WRONG_CHECKSUM = "its checksum is wrong"


class Place(NamedTuple):
    """A record in a file. number: among records of the same kind, from 1. start, length: of its content."""

    kind: Opcode
    number: int
    start: int
    length: int

    def __str__(self) -> str:
        name = self.kind.name.lower().replace("_", " ")
        return f"{name} {self.number} (bytes {self.start - RECORD_HEAD:,} to {self.start + self.length - 1:,})"


class ChunkPlace(NamedTuple):
    """A chunk of a file. checksum: CRC-32 of the record's content. channels: those with messages in the chunk."""

    place: Place
    checksum: int
    channels: frozenset[int]


@dataclass
class Contents:
    """The contents of a file except its messages. metadata, attachments: keyed by name.

    schemas, channels: keyed by number. counts: number of messages per channel. last_ns: the last time in the last
    chunk. is_ours: whether uwsim wrote the file itself. is_whole: whether the data are complete; complete: whether the
    index is also complete.
    """

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)
    chunks: list[ChunkPlace] = field(default_factory=list)
    last_ns: int | None = None
    is_ours: bool = False
    is_whole: bool = False
    complete: bool = False


def places(file: IO[bytes]) -> Iterator[Place]:
    """Yield the places of a file's records up to the footer, with the file at the content of each.

    Raises ValueError for bytes that are no record, and EndOfFile where the file ends in the middle of one.
    """
    size, numbers = file.seek(0, 2), Counter[int]()
    file.seek(0)
    if (magic := file.read(len(MCAP0_MAGIC))) != MCAP0_MAGIC:
        if MCAP0_MAGIC.startswith(magic):
            raise EndOfFile
        raise ValueError("its first bytes are not MCAP's")
    at, kind = file.tell(), Opcode.HEADER
    while kind != Opcode.FOOTER:
        file.seek(at)
        if len(head := file.read(RECORD_HEAD)) < RECORD_HEAD:
            raise EndOfFile
        number, length = struct.unpack("<BQ", head)
        if number not in PARSERS:
            raise ValueError(f"damaged: at byte {at:,}: 0x{number:02x} is no kind of record of a recording")
        kind = Opcode(number)
        if length > size - file.tell():
            raise EndOfFile
        numbers[kind] += 1
        yield Place(kind, numbers[kind], at + RECORD_HEAD, length)
        at += RECORD_HEAD + length


def parsed(kind: Opcode, content: bytes) -> Any:
    """Return a record. Raises ValueError if its content is invalid."""
    stream = ReadDataStream(BytesIO(content))
    try:
        record = PARSERS[kind].read(stream)
    except UNREADABLE as error:
        raise ValueError(f"it cannot be read: {str(error) or type(error).__name__}") from None
    if stream.count != len(content):
        raise ValueError(f"it has {len(content) - stream.count:,} bytes too many")
    return record


def read_contents(path: Path) -> Contents:
    """Read a file to its end, or to the point where it is cut off. Raises ValueError if it is damaged, or OSError."""
    with require_regular(path).open("rb") as file:
        reader = _Reader(path, file)
        try:
            reader.read()
        except EndOfFile:
            if _ends_whole(file):
                raise ValueError(f"recording '{path}': damaged: a record reaches beyond the file's end") from None
            if reader.contents.metadata and not reader.contents.is_ours:
                raise ValueError(f"recording '{path}': damaged: it is cut off, and its header is not uwsim's") from None
        return reader.contents


def _ends_whole(file: IO[bytes]) -> bool:
    size = file.seek(0, 2)
    file.seek(max(0, size - len(MCAP0_MAGIC)))
    return size >= 2 * len(MCAP0_MAGIC) and file.read() == MCAP0_MAGIC


def read_messages(path: Path, chunks: Sequence[ChunkPlace]) -> Iterator[Message]:
    """Yield the messages in chunks. Raises ValueError if a chunk has changed since it was first read, or OSError."""
    with path.open("rb") as file:
        for place, checksum, _ in chunks:
            file.seek(place.start)
            content = file.read(place.length)
            if zlib.crc32(content) != checksum:
                raise ValueError(f"recording '{path}': {place}: has changed since the file was opened")
            for record in in_chunk(parsed(place.kind, content)):
                if isinstance(record, Message):
                    yield record


class _Reader:
    """Reads and verifies the records of a file, filling in `contents`."""

    def __init__(self, path: Path, file: IO[bytes]) -> None:
        self.contents = Contents()
        self._path, self._file = path, file
        self._start_checksum: int | None = None  # checksum of the leading metadata, from the header
        self._sequences: dict[int, int] = {}  # sequence number of the last message on each channel
        self._checksum = zlib.crc32(MCAP0_MAGIC)  # of the data so far, then of the summary

    def read(self) -> None:
        """Read all records. Raises EndOfFile or ValueError."""
        try:
            for place in places(self._file):
                content = self._file.read(place.length)
                try:
                    self._add(place, content, parsed(place.kind, content))
                except ValueError as error:
                    raise ValueError(f"damaged: {place}: {error}") from None
                head = struct.pack("<BQ", place.kind, place.length)
                self._checksum = 0 if place.kind == Opcode.DATA_END else zlib.crc32(head + content, self._checksum)
            if len(end := self._file.read(len(MCAP0_MAGIC) + 1)) < len(MCAP0_MAGIC) and MCAP0_MAGIC.startswith(end):
                raise EndOfFile
            if end != MCAP0_MAGIC:
                raise ValueError("damaged: its last bytes are wrong")
        except ValueError as error:
            is_ours = self.contents.is_ours or START in self.contents.metadata
            raise ValueError(f"recording '{self._path}': {error if is_ours else NOT_OURS}") from None
        self.contents.complete = True

    def _add(self, place: Place, content: bytes, record: Any) -> None:
        contents = self.contents
        is_first = place.start == len(MCAP0_MAGIC) + RECORD_HEAD
        if isinstance(record, Header) != is_first or contents.is_whole == (place.kind in DATA):
            raise ValueError("it is out of place")
        match record:
            case Header():
                self._add_header(record)
            case Metadata(name=name):
                if name == START and self._start_checksum not in (None, zlib.crc32(content)):
                    raise ValueError(WRONG_CHECKSUM)
                _add_new(contents.metadata, name, record.metadata)
            case Attachment(name=name):
                self._compare(int.from_bytes(content[-4:], "little"), zlib.crc32(content[:-4]))
                _add_new(contents.attachments, name, record.data)
            case Chunk():
                contents.chunks.append(ChunkPlace(place, zlib.crc32(content), self._add_chunk(record)))
            case MessageIndex():
                if not contents.chunks or record.channel_id not in contents.chunks[-1].channels:
                    raise ValueError("it is out of place")
            case DataEnd():
                self._compare(record.data_section_crc, self._checksum)
                contents.is_whole = True
            case Footer():
                head = struct.pack("<BQ", place.kind, place.length)
                self._compare(record.summary_crc, zlib.crc32(head + content[:-4], self._checksum))
            case Schema() | Channel():
                self._announce(record)

    def _add_header(self, header: Header) -> None:
        if (found := LIBRARY.fullmatch(header.library)) is None:
            return
        if header.profile != PROFILE:
            raise ValueError(f"its profile is {header.profile!r}, not {PROFILE!r}")
        self.contents.is_ours = True
        self._start_checksum = int(found[1], 16)

    def _add_chunk(self, chunk: Chunk) -> frozenset[int]:
        """Verify a chunk, and return its channels."""
        times_ns, channels = list[int](), Counter[int]()
        for record in in_chunk(chunk, self._compare):
            if isinstance(record, Message):
                self._require_in_turn(record)
                times_ns.append(record.log_time)
                channels[record.channel_id] += 1
            else:
                self._announce(record)
        self.contents.counts.update(channels)
        self.contents.last_ns = max(times_ns, default=self.contents.last_ns)
        return frozenset(channels)

    def _announce(self, record: Channel | Schema) -> None:
        known: dict[int, Any] = self.contents.channels if isinstance(record, Channel) else self.contents.schemas
        if known.setdefault(record.id, record) != record:
            raise ValueError(f"its {type(record).__name__.lower()} {record.id} differs from an earlier one")

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
        """Raise ValueError if a checksum differs from the stored one; other tools may store 0, which means none."""
        if given != found and (given or self.contents.is_ours):
            raise ValueError(WRONG_CHECKSUM)


def _add_new(known: dict[str, Any], name: str, value: Any) -> None:
    if name in known:
        raise ValueError(f"'{name}' occurs twice")
    known[name] = value
