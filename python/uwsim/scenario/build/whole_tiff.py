"""Checks that a TIFF is complete, since GDAL and Pillow return zeros or uninitialised data for missing parts."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

from PIL.TiffImagePlugin import ImageFileDirectory_v2

from uwsim.base.caught_warnings import caught_warnings

MAX_DIRECTORIES = 256
BIG = (b"II\x2b\0", b"MM\0\x2b")
MAGIC = (b"II\x2a\0", b"MM\0\x2a", *BIG)
WIDTH, HEIGHT, BITS, COMPRESSION, SAMPLES, PLANAR = 256, 257, 258, 259, 277, 284
UNCOMPRESSED, DEFLATE, SEPARATE = 1, (8, 32946), 2
OFFSETS, ROWS, COUNTS = 273, 278, 279
TILE_WIDTH, TILE_HEIGHT, TILE_OFFSETS, TILE_COUNTS = 322, 323, 324, 325


def require_whole_tiff(path: Path) -> None:
    """Raise ValueError if a TIFF lacks some of its strips or tiles, OSError if it cannot be read.

    Other formats are accepted without a check.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(4) not in MAGIC:
            return
        try:
            for tags in _directories(file):
                _require_parts(file, tags, size)
        except (ValueError, OSError):
            raise
        except Exception as error:  # for missing or mistyped tags, Pillow raises errors of any type
            raise ValueError(f"damaged tags: {type(error).__name__}: {error}") from None


def _directories(file: IO[bytes]) -> Iterator[dict[int, Any]]:
    """Yield the tags of each image in the file; overviews and masks are separate images."""
    file.seek(0)
    header = file.read(8)
    header += file.read(8) if header[:4] in BIG else b""
    directory, seen = ImageFileDirectory_v2(header), set[int]()
    while directory.next and directory.next not in seen and len(seen) < MAX_DIRECTORIES:
        seen.add(directory.next)
        file.seek(directory.next)
        with caught_warnings() as issued:
            directory.load(file)
        messages = [str(warning.message) for warning in issued]
        # A metadata warning only means surplus values.
        if lost := [text for text in messages if not text.startswith("Metadata Warning")]:
            raise ValueError(f"damaged tags: {lost[0]}")
        yield dict(directory)


def _require_parts(file: IO[bytes], tags: dict[int, Any], size: int) -> None:
    tiled = TILE_OFFSETS in tags
    offsets, counts = (tags[tag] for tag in ((TILE_OFFSETS, TILE_COUNTS) if tiled else (OFFSETS, COUNTS)))
    expected, unpacked = _tiles(tags) if tiled else _strips(tags)
    if not len(offsets) == len(counts) == expected:
        raise ValueError(f"{len(offsets)} offsets and {len(counts)} lengths for {expected} strips or tiles")
    compression = tags.get(COMPRESSION, UNCOMPRESSED)
    for number, (offset, count) in enumerate(zip(offsets, counts, strict=True)):
        if count == 0:  # no data: a sparse file
            continue
        if offset + count > size or (compression == UNCOMPRESSED and count < unpacked(number)):
            raise ValueError("a strip or tile ends beyond the file, which may be cut short")
        if compression in DEFLATE:
            file.seek(offset)
            _require_unpacks(file.read(count), unpacked(number))


def _require_unpacks(data: bytes, size: int) -> None:
    """Raise ValueError if a deflated part is damaged; GDAL would silently return an uninitialised buffer."""
    reader = zlib.decompressobj()
    try:
        found = len(reader.decompress(data, size + 1))
    except zlib.error as error:
        raise ValueError(f"a strip or tile is damaged: {error}") from None
    if found < size or not reader.eof:
        raise ValueError(f"a strip or tile is damaged: it unpacks to {found} bytes, expected {size}")


def _tiles(tags: dict[int, Any]) -> tuple[int, Callable[[int], int]]:
    """Return the expected number of tiles, and a function from tile index to unpacked size in bytes."""
    planes, row_bits = _planes(tags, tags[TILE_WIDTH])
    across, down = -(-tags[WIDTH] // tags[TILE_WIDTH]), -(-tags[HEIGHT] // tags[TILE_HEIGHT])
    tile_bytes = tags[TILE_HEIGHT] * -(-row_bits // 8)
    return planes * across * down, lambda _: tile_bytes


def _strips(tags: dict[int, Any]) -> tuple[int, Callable[[int], int]]:
    """Return the expected number of strips, and a function from strip index to unpacked size in bytes."""
    planes, row_bits = _planes(tags, tags[WIDTH])
    height: int = tags[HEIGHT]
    rows = min(tags.get(ROWS, height), height)
    strips = -(-height // rows)

    def unpacked(number: int) -> int:
        return int(min(rows, height - number % strips * rows)) * -(-row_bits // 8)

    return planes * strips, unpacked


def _planes(tags: dict[int, Any], width: int) -> tuple[int, int]:
    """Return the number of planes and the number of bits per row of a plane."""
    bits = tags.get(BITS, (1,))
    separate = tags.get(PLANAR, 1) == SEPARATE
    samples = tags.get(SAMPLES, 1)
    return (samples, width * bits[0]) if separate else (1, width * bits[0] * samples)
