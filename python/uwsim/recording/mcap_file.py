"""MCAP (mcap.dev/spec): written in chunks, each with many messages at once, and unpacked, whatever chunks state.

The `mcap` library's writer makes every message and its index entry by itself, which takes ten times as long. Its
records are used for everything else.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import IO, Any, cast

import lz4.frame
import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

CHUNK_BYTES = 1 << 20
HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("size", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("logged", "<u8"),
        ("published", "<u8"),
    ]
)
"""A message's record before its data."""
INDEX_HEAD = np.dtype([("opcode", "u1"), ("size", "<u8"), ("channel", "<u2"), ("bytes", "<u4")])
RECORD_HEAD = 9  # opcode and size of any record


class McapFile:
    """An MCAP file with checksums, whose chunks are compressed by LZ4.

    Records other than those of chunks are written at once. Its methods raise OSError.
    """

    def __init__(self, stream: IO[bytes], profile: str, library: str) -> None:
        """stream: at its beginning."""
        self._stream = stream
        self._crc = 0
        self._schemas: list[records.Schema] = []
        self._channels: list[records.Channel] = []
        self._chunks: list[records.ChunkIndex] = []
        self._attachments: list[records.AttachmentIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self._counts: Counter[int] = Counter()
        self._first_ns, self._last_ns = 0, 0
        self._begin_chunk()
        self._write(MCAP0_MAGIC)
        self._write(_bytes(records.Header(profile, library)))

    def _begin_chunk(self) -> None:
        self._pieces: list[bytes | memoryview] = []
        self._size = 0
        self._index: list[tuple[NDArray[np.uint16], NDArray[np.uint64], NDArray[np.uint64]]] = []

    def _write(self, data: bytes) -> None:
        self._crc = zlib.crc32(data, self._crc)
        self._stream.write(data)

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Write a metadata record."""
        offset, content = self._stream.tell(), _bytes(records.Metadata(name, dict(data)))
        self._write(content)
        self._metadata.append(records.MetadataIndex(offset=offset, length=len(content), name=name))

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment of time 0."""
        offset = self._stream.tell()
        content = _bytes(records.Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data))
        self._write(content)
        self._attachments.append(records.AttachmentIndex(offset, len(content), 0, 0, len(data), name, media_type))

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema to the present chunk; return its number."""
        self._schemas.append(records.Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name))
        self._put(_bytes(self._schemas[-1]))
        return len(self._schemas)

    def add_channel(self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]) -> int:
        """Add a channel to the present chunk; return its number."""
        number = len(self._channels) + 1
        self._channels.append(records.Channel(number, topic, encoding, dict(metadata), schema))
        self._put(_bytes(self._channels[-1]))
        return number

    def _put(self, data: bytes) -> None:
        self._pieces.append(data)
        self._size += len(data)

    def add_messages(
        self,
        channels: Sequence[int] | NDArray[np.integer[Any]],
        times_ns: Sequence[int] | NDArray[np.integer[Any]],
        sequences: Sequence[int] | NDArray[np.integer[Any]],
        data: Sequence[bytes | memoryview],
    ) -> None:
        """Add messages to the present chunk and, whenever that is full, to another. times_ns: logged and published."""
        heads = np.empty(len(data), HEAD)
        lengths = np.fromiter(map(len, data), np.int64, len(data))
        heads["opcode"] = Opcode.MESSAGE
        heads["size"] = lengths + (HEAD.itemsize - RECORD_HEAD)
        heads["channel"], heads["sequence"] = channels, sequences
        heads["logged"] = heads["published"] = times_ns
        ends = np.cumsum(lengths + HEAD.itemsize)
        texts = cast(list[bytes], heads.view(np.dtype((np.void, HEAD.itemsize))).tolist())
        first, before = 0, 0
        while first < len(data):
            last = first + int(np.searchsorted(ends[first:], before + CHUNK_BYTES - self._size, "right")) + 1
            part = slice(first, min(last, len(data)))
            offsets = ends[part] - lengths[part] - (HEAD.itemsize + before - self._size)
            self._index.append((heads["channel"][part], heads["logged"][part], offsets.astype(np.uint64)))
            pieces: list[bytes | memoryview] = [b""] * (2 * (part.stop - part.start))
            pieces[::2], pieces[1::2] = texts[part], data[part]
            self._pieces += pieces
            self._size += int(ends[part][-1]) - before
            first, before = part.stop, int(ends[part.stop - 1])
            if self._size > CHUNK_BYTES:
                self._end_chunk()

    def flush(self) -> None:
        """End the present chunk, if it has messages, and pass everything to the operating system."""
        self._end_chunk()
        self._stream.flush()

    def _end_chunk(self) -> None:
        if not self._index:
            return
        channels, times_ns, offsets = (np.concatenate(column) for column in zip(*self._index, strict=True))
        data = b"".join(self._pieces)
        packed = lz4.frame.compress(data)
        first_ns, last_ns = int(times_ns.min()), int(times_ns.max())
        self._first_ns = min(self._first_ns, first_ns) if self._counts else first_ns
        self._last_ns = max(self._last_ns, last_ns)
        chunk = _bytes(records.Chunk("lz4", packed, last_ns, first_ns, zlib.crc32(data), len(data)))
        start = self._stream.tell()
        self._write(chunk)
        index_start, index = start + len(chunk), bytearray()
        places: dict[int, int] = {}
        _, firsts = np.unique(channels, return_index=True)
        for channel in channels[np.sort(firsts)].tolist():
            places[channel] = index_start + len(index)
            own = channels == channel
            entries = np.column_stack((times_ns[own], offsets[own])).astype("<u8").tobytes()
            size = INDEX_HEAD.itemsize - RECORD_HEAD + len(entries)
            index += np.array((Opcode.MESSAGE_INDEX, size, channel, len(entries)), INDEX_HEAD).tobytes() + entries
            self._counts[channel] += int(own.sum())
        self._write(bytes(index))
        self._chunks.append(
            records.ChunkIndex(len(chunk), start, "lz4", len(packed), last_ns, len(index), places, first_ns, len(data))
        )
        self._begin_chunk()

    def finish(self) -> None:
        """Write the last chunk, the end of the data, and the summary."""
        self._end_chunk()
        self._write(_bytes(records.DataEnd(self._crc)))
        statistics = records.Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=self._last_ns,
            message_start_time=self._first_ns,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        groups: list[tuple[Opcode, Sequence[Any]]] = [
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.ATTACHMENT_INDEX, self._attachments),
            (Opcode.METADATA_INDEX, self._metadata),
        ]
        start, summary, offsets = self._stream.tell(), bytearray(), bytearray()
        for opcode, group in groups:
            text = b"".join(map(_bytes, group))
            offsets += _bytes(records.SummaryOffset(opcode, start + len(summary), len(text)))
            summary += text
        offset_start = start + len(summary)
        summary += offsets
        footer = _bytes(records.Footer(start, offset_start, 0))
        crc = zlib.crc32(footer[:-4], zlib.crc32(summary))  # of the summary and of the footer up to its checksum
        self._stream.write(bytes(summary) + _bytes(records.Footer(start, offset_start, crc)) + MCAP0_MAGIC)


def _bytes(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()  # type: ignore[no-any-return, no-untyped-call]


FREE_BYTES, BYTES_PER_BYTE = 64_000_000, 255
"""The most that a chunk may hold: so much, and so much for each of its compressed bytes, which is LZ4's best."""
UNREADABLE = (McapError, struct.error, RuntimeError, ValueError, EOFError, OverflowError, MemoryError)
"""Errors raised for damaged content; RuntimeError comes from lz4, ValueError also from bytes that are not text."""


def in_chunk(chunk: Chunk, compare: Callable[[int, int], None] = lambda given, found: None) -> list[Any]:
    """Return the records in a chunk. compare: called with its checksum and that of its content. Raises ValueError."""
    data = unpacked(chunk)
    compare(chunk.uncompressed_crc, zlib.crc32(data))
    plain = Chunk("", data, chunk.message_end_time, chunk.message_start_time, 0, len(data))
    try:
        return breakup_chunk(plain)
    except UNREADABLE as error:
        raise ValueError(f"it cannot be read: {str(error) or type(error).__name__}") from None


def unpacked(chunk: Chunk) -> bytes:
    """Return the content of a chunk. Raises ValueError if the chunk is damaged, or states or holds too much."""
    size = chunk.uncompressed_size
    if size > (most := FREE_BYTES + BYTES_PER_BYTE * len(chunk.data)):
        raise ValueError(f"its size of {size:,} bytes is too large: must be at most {most:,}")
    try:
        data = _decompressed(chunk, size + 1)
    except UNREADABLE as error:
        raise ValueError(f"it cannot be decompressed: {str(error) or type(error).__name__}") from None
    if len(data) != size:
        more = "more than " if len(data) > size and chunk.compression else ""
        raise ValueError(f"it holds {more}{len(data) - bool(more):,} bytes, not {size:,}")
    return data


def _decompressed(chunk: Chunk, most: int) -> bytes:
    """Return at most so many bytes of a chunk's content, whatever it states; `mcap` would unpack all of them."""
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
