"""Unpacks the chunks of a recording, whatever they state."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Chunk
from mcap.stream_reader import breakup_chunk

CHUNK_BYTES, BYTES_PER_BYTE = 64_000_000, 255
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
    if size > (most := CHUNK_BYTES + BYTES_PER_BYTE * len(chunk.data)):
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
