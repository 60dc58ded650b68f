"""Reads the records of a recording file one by one, with their positions, to detect and locate damage.

An MCAP record consists of a kind, a length and the content. If the process was killed, the file ends in the middle of
its last record. Anything else that cannot be read is damage.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, NamedTuple, cast

from mcap import records as kinds
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

MAGIC = b"\x89MCAP0\r\n"
CHUNK_BYTES, BYTES_PER_BYTE = 64_000_000, 255
"""The most that a chunk may hold: so much, and so much for each of its compressed bytes, which is LZ4's best."""
FIRST = len(MAGIC)
"""Position of the first record."""
_HEAD = struct.Struct("<BQ")  # kind, length of the content
HEAD_BYTES = _HEAD.size
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, times of recording and of publishing
_PEEKED = 1 << 16  # number of bytes read from a truncated record, enough to contain its length fields
_UNREADABLE = (McapError, struct.error, RuntimeError, ValueError, EOFError, OverflowError, MemoryError)
"""Errors raised for damaged content; RuntimeError comes from lz4, ValueError also from bytes that are not text."""


class Layout(NamedTuple):
    """A kind of record.

    parts: the fields of the content, each given as a number of bytes or, if negative, as the size of a length field
    that is followed by that many bytes.
    """

    name: str
    parser: Any
    parts: tuple[int, ...]


LAYOUTS = {
    Opcode.HEADER: Layout("the header", kinds.Header, (-4, -4)),
    Opcode.FOOTER: Layout("the footer", kinds.Footer, (20,)),
    Opcode.SCHEMA: Layout("schema", kinds.Schema, (2, -4, -4, -4)),
    Opcode.CHANNEL: Layout("channel", kinds.Channel, (4, -4, -4, -4)),
    Opcode.CHUNK: Layout("chunk", kinds.Chunk, (28, -4, -8)),
    Opcode.MESSAGE_INDEX: Layout("message index", kinds.MessageIndex, (2, -4)),
    Opcode.CHUNK_INDEX: Layout("chunk index", kinds.ChunkIndex, (32, -4, 8, -4, 16)),
    Opcode.ATTACHMENT: Layout("attachment", kinds.Attachment, (16, -4, -4, -8, 4)),
    Opcode.ATTACHMENT_INDEX: Layout("attachment index", kinds.AttachmentIndex, (40, -4, -4)),
    Opcode.STATISTICS: Layout("the statistics", kinds.Statistics, (42, -4)),
    Opcode.METADATA: Layout("metadata", kinds.Metadata, (-4, -4)),
    Opcode.METADATA_INDEX: Layout("metadata index", kinds.MetadataIndex, (16, -4)),
    Opcode.SUMMARY_OFFSET: Layout("summary offset", kinds.SummaryOffset, (17,)),
    Opcode.DATA_END: Layout("the end of the data", kinds.DataEnd, (4,)),
}
"""The kinds of records in a recording. Messages are in chunks, with the schemas and channels that they need."""


class CutOffError(Exception):
    """The file ends in the middle of a record, as after a kill."""


class Message(NamedTuple):
    """A message in a chunk. offset: position of the record in the unpacked chunk."""

    channel_id: int
    sequence: int
    time_ns: int
    data: bytes
    offset: int


class Record(NamedTuple):
    """A record in the file. start: its position. number: its number among records of the same kind, from 1."""

    kind: int
    number: int
    start: int
    content: bytes

    @property
    def length(self) -> int:
        """The record's length in bytes."""
        return HEAD_BYTES + len(self.content)

    @property
    def head(self) -> bytes:
        """The bytes before the record's content."""
        return _HEAD.pack(self.kind, len(self.content))

    @property
    def place(self) -> str:
        """A description of the record with its byte range."""
        return _place(self.kind, self.number, self.start, self.start + self.length)

    @contextmanager
    def named(self, file: RecordFile) -> Iterator[None]:
        """Convert a ValueError raised in the block to an error for a damaged file that names the record."""
        try:
            yield
        except ValueError as error:
            raise file.damaged(f"{self.place}: {error}") from None

    def parsed(self) -> Any:
        """Return the record, parsed according to its kind. Raises ValueError if its content is invalid."""
        return _parsed(LAYOUTS[Opcode(self.kind)].parser, self.content)


def _place(kind: int, number: int, start: int, end: int) -> str:
    name = LAYOUTS[Opcode(kind)].name
    return f"{name}{'' if name.startswith('the ') else f' {number}'} (bytes {start:,} to {end - 1:,})"


class RecordFile:
    """A file that is read record by record.

    position: the current position in the file. checksum: CRC-32 of everything read since it was last set to 0.
    """

    def __init__(self, path: Path, file: IO[bytes]) -> None:
        self.path = path
        self.position = 0
        self.checksum = 0
        self._file = file
        self._size = os.fstat(file.fileno()).st_size
        self._numbers: dict[int, int] = {}

    def damaged(self, what: str) -> ValueError:
        """Return the error for a damaged file."""
        return ValueError(f"recording '{self.path}': damaged: {what}")

    def magic(self) -> bool:
        """Return whether the next bytes are the magic bytes at the beginning and end of every MCAP file.

        Raises CutOffError if the file ends in the middle of them.
        """
        found = self._read(min(len(MAGIC), self._size - self.position))
        if len(found) < len(MAGIC) and MAGIC.startswith(found):
            raise CutOffError
        return found == MAGIC

    @property
    def is_at_end(self) -> bool:
        """Whether the end of the file has been reached."""
        return self.position == self._size

    def record(self) -> Record:
        """Read the next record. Raises CutOffError or ValueError."""
        start = self.position
        if self._size - start < HEAD_BYTES:
            if self._ends_whole:
                raise self.damaged(f"no record is at bytes {start:,} to {self._size - 1:,}")
            raise CutOffError
        kind, length = _HEAD.unpack(self._read(HEAD_BYTES))
        if kind not in LAYOUTS:
            raise self.damaged(f"at byte {start:,}: 0x{kind:02x} is no kind of record of a recording")
        number = self._numbers[kind] = self._numbers.get(kind, 0) + 1
        if length > self._size - self.position:
            self._require_cut_off(kind, number, start, length)
            raise CutOffError
        return Record(kind, number, start, self._read(length))

    @property
    def _ends_whole(self) -> bool:
        """Whether the file ends with the magic bytes of a finished file."""
        if self._size < 2 * len(MAGIC):
            return False
        here = self._file.tell()
        self._file.seek(-len(MAGIC), os.SEEK_END)
        last = self._file.read(len(MAGIC))
        self._file.seek(here)
        return last == MAGIC

    def _require_cut_off(self, kind: int, number: int, start: int, length: int) -> None:
        """Raise ValueError unless a record is cut off, as opposed to having a wrong length."""
        peeked = self._file.read(min(_PEEKED, self._size - self.position))
        expected = _length(LAYOUTS[Opcode(kind)].parts, peeked)
        if self._ends_whole or expected not in (None, length):
            where = _place(kind, number, start, self._size)
            raise self.damaged(f"{where}: its length of {length:,} bytes is wrong")

    def _read(self, size: int) -> bytes:
        data = self._file.read(size)
        if len(data) < size:
            raise CutOffError
        self.position += size
        self.checksum = zlib.crc32(data, self.checksum)
        return data


def unpacked(chunk: kinds.Chunk) -> bytes:
    """Return the content of a chunk. Raises ValueError if the chunk is damaged, or states or holds too much."""
    size = chunk.uncompressed_size
    if size > (most := CHUNK_BYTES + BYTES_PER_BYTE * len(chunk.data)):
        raise ValueError(f"its size of {size:,} bytes is too large: must be at most {most:,}")
    try:
        data = _decompressed(chunk, size + 1)
    except _UNREADABLE as error:
        raise ValueError(f"it cannot be decompressed: {str(error) or type(error).__name__}") from None
    if len(data) != size:
        more = "more than " if len(data) > size and chunk.compression else ""
        raise ValueError(f"it holds {more}{len(data) - bool(more):,} bytes, not {size:,}")
    return data


def _decompressed(chunk: kinds.Chunk, most: int) -> bytes:
    """Return at most so many bytes of a chunk's content, whatever it states."""
    if chunk.compression == "zstd":
        import zstandard  # both come with mcap

        try:
            return bytes(zstandard.ZstdDecompressor().stream_reader(chunk.data).read(most))
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None
    if chunk.compression == "lz4":
        import lz4.frame

        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=most))
    return chunk.data


def in_chunk(data: bytes) -> Iterator[Message | kinds.Channel | kinds.Schema]:
    """Yield the records in an unpacked chunk. Raises ValueError for invalid records."""
    at = 0
    while at < len(data):
        if len(data) - at < HEAD_BYTES:
            raise ValueError("its last record is cut off")
        kind, length = _HEAD.unpack_from(data, at)
        begin, end = at + HEAD_BYTES, at + HEAD_BYTES + length
        if end > len(data):
            raise ValueError("its last record is cut off")
        if kind == Opcode.MESSAGE:
            if length < _MESSAGE.size:
                raise ValueError("a message of it is too short")
            channel_id, sequence, time_ns, _ = _MESSAGE.unpack_from(data, begin)
            yield Message(channel_id, sequence, time_ns, data[begin + _MESSAGE.size : end], at)
        elif kind in (Opcode.CHANNEL, Opcode.SCHEMA):
            yield _parsed(LAYOUTS[Opcode(kind)].parser, data[begin:end])
        else:
            raise ValueError(f"0x{kind:02x} is no kind of record in a chunk")
        at = end


class _Strict:
    """A byte stream that raises an error if read beyond its end."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self.position = 0

    def read(self, size: int) -> bytes:
        """Return this many bytes. Raises EOFError if there are fewer."""
        if size > len(self._content) - self.position:
            raise EOFError("it ends early")
        self.position += size
        return self._content[self.position - size : self.position]


def _parsed(parser: Any, content: bytes) -> Any:
    stream = _Strict(content)
    try:
        record = parser.read(ReadDataStream(cast(IO[bytes], stream)))
    except _UNREADABLE as error:
        raise ValueError(f"it cannot be read: {str(error) or type(error).__name__}") from None
    if stream.position != len(content):
        raise ValueError(f"it has {len(content) - stream.position:,} bytes too many")
    return record


def _length(parts: tuple[int, ...], content: bytes) -> int | None:
    """Return the length of the content according to its length fields, or None if some of these are missing."""
    at = 0
    for part in parts:
        if part > 0:
            at += part
            continue
        prefix = content[at : at - part]
        if len(prefix) < -part:
            return None
        at += -part + int.from_bytes(prefix, "little")
    return at
