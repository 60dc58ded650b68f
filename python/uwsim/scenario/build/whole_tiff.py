"""Whether a TIFF is whole: GDAL and Pillow leave the parts that a file lacks as they find them in memory, or zero."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

from PIL.TiffImagePlugin import ImageFileDirectory_v2

MAX_DIRECTORIES = 256
BIG = (b"II\x2b\0", b"MM\0\x2b")
MAGIC = (b"II\x2a\0", b"MM\0\x2a", *BIG)
WIDTH, HEIGHT, BITS, COMPRESSION, SAMPLES, PLANAR = 256, 257, 258, 259, 277, 284
UNCOMPRESSED, SEPARATE = 1, 2
OFFSETS, ROWS, COUNTS = 273, 278, 279
TILE_WIDTH, TILE_HEIGHT, TILE_OFFSETS, TILE_COUNTS = 322, 323, 324, 325


def require_whole_tiff(path: Path) -> None:
    """Raise ValueError if a TIFF lacks some of its strips or tiles, OSError. Files of other formats pass."""
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(4) not in MAGIC:
            return
        try:
            for tags in _directories(file):
                _require_parts(tags, size)
        except (ValueError, OSError):
            raise
        except Exception as error:  # tags that lack, or are of other types: Pillow raises errors of any type, too
            raise ValueError(f"damaged tags: {type(error).__name__}: {error}") from None


def _directories(file: IO[bytes]) -> Iterator[dict[int, Any]]:
    """Yield the tags of each image in the file: overviews and masks are images of their own."""
    file.seek(0)
    header = file.read(8)
    header += file.read(8) if header[:4] in BIG else b""
    directory, seen = ImageFileDirectory_v2(header), set[int]()
    while directory.next and directory.next not in seen and len(seen) < MAX_DIRECTORIES:
        seen.add(directory.next)
        file.seek(directory.next)
        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("always")
            directory.load(file)
        said = [str(warning.message) for warning in issued]
        if lost := [text for text in said if not text.startswith("Metadata Warning")]:  # more numbers than expected
            raise ValueError(f"damaged tags: {lost[0]}")
        yield dict(directory)


def _require_parts(tags: dict[int, Any], size: int) -> None:
    tiled = TILE_OFFSETS in tags
    offsets, counts = (tags[tag] for tag in ((TILE_OFFSETS, TILE_COUNTS) if tiled else (OFFSETS, COUNTS)))
    expected, least = _tiles(tags) if tiled else _strips(tags)
    if not len(offsets) == len(counts) == expected:
        raise ValueError(f"{len(offsets)} offsets and {len(counts)} lengths for {expected} strips or tiles")
    for number, (offset, count) in enumerate(zip(offsets, counts, strict=True)):
        if count and (offset + count > size or count < least(number)):  # 0: a part without data, of a sparse file
            raise ValueError("a strip or tile ends beyond the file, which may be cut short")


def _tiles(tags: dict[int, Any]) -> tuple[int, Callable[[int], int]]:
    """Return how many tiles there must be, and how many bytes each has at least."""
    planes, row_bits = _planes(tags, tags[TILE_WIDTH])
    across, down = -(-tags[WIDTH] // tags[TILE_WIDTH]), -(-tags[HEIGHT] // tags[TILE_HEIGHT])
    tile_bytes = _least(tags, row_bits, tags[TILE_HEIGHT])
    return planes * across * down, lambda _: tile_bytes


def _strips(tags: dict[int, Any]) -> tuple[int, Callable[[int], int]]:
    """Return how many strips there must be, and how many bytes each has at least."""
    planes, row_bits = _planes(tags, tags[WIDTH])
    rows = min(tags.get(ROWS, tags[HEIGHT]), tags[HEIGHT])
    strips = -(-tags[HEIGHT] // rows)

    def least(number: int) -> int:
        return _least(tags, row_bits, min(rows, tags[HEIGHT] - number % strips * rows))

    return planes * strips, least


def _planes(tags: dict[int, Any], width: int) -> tuple[int, int]:
    """Return the number of planes, and the bits of a row of one."""
    bits = tags.get(BITS, (1,))
    separate = tags.get(PLANAR, 1) == SEPARATE
    samples = tags.get(SAMPLES, 1)
    return (samples, width * bits[0]) if separate else (1, width * bits[0] * samples)


def _least(tags: dict[int, Any], row_bits: int, rows: int) -> int:
    """Return the bytes of so many rows; of compressed ones 1."""
    return rows * -(-row_bits // 8) if tags.get(COMPRESSION, UNCOMPRESSED) == UNCOMPRESSED else 1
