"""A chunk of a recording unpacks to what it states, and to no more than its bytes may hold."""

import tracemalloc

import lz4.frame
import pytest
import zstandard
from mcap.records import Chunk

from uwsim.recording.mcap_file import BYTES_PER_BYTE, FREE_BYTES, unpacked

SIZE = 100_000_000
PACKED = {"lz4": lz4.frame.compress(bytes(SIZE)), "zstd": zstandard.compress(bytes(SIZE)), "": bytes(1000)}


def chunk(compression: str, stated: int, data: bytes | None = None) -> Chunk:
    return Chunk(
        compression=compression, data=PACKED[compression] if data is None else data, message_end_time=0,
        message_start_time=0, uncompressed_crc=0, uncompressed_size=stated,
    )  # fmt: skip


@pytest.mark.parametrize("compression", PACKED)
def test_a_chunk_that_holds_more_than_it_states_is_not_unpacked(compression: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"not 999$"):
            unpacked(chunk(compression, 999))
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_a_size_beyond_what_its_bytes_may_hold_is_refused_before() -> None:
    data = PACKED["zstd"]
    most = FREE_BYTES + BYTES_PER_BYTE * len(data)
    with pytest.raises(ValueError, match=f"its size of {SIZE:,} bytes is too large: must be at most {most:,}"):
        unpacked(chunk("zstd", SIZE, data))


@pytest.mark.parametrize("compression", PACKED)
def test_whole_and_cut_off_chunks(compression: str) -> None:
    content = bytes(range(256)) * 40
    data = {"lz4": lz4.frame.compress, "zstd": zstandard.compress, "": bytes}[compression](content)
    assert unpacked(chunk(compression, len(content), data)) == content
    with pytest.raises(ValueError, match=r"it holds|it cannot be decompressed"):
        unpacked(chunk(compression, len(content), data[:-9]))
