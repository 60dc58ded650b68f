"""Encoding and writing of PNG and JPEG files."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically

SUFFIXES = (".png", ".jpg", ".jpeg")
SIGNATURE = b"\x89PNG\r\n\x1a\n"
SUB = 1
"""The filter of each row: differences from the previous pixel. Pillow tries all five filters in each row, which takes
longer than the compression, and saves 3 % of a picture of water and nothing of a sonar's."""


def check_suffix(name: str, path: Path) -> None:
    """Raise ValueError unless the path ends in .png, .jpg or .jpeg. name: how the message refers to the path."""
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"{name} = {path}: must end in .png, .jpg or .jpeg")


def encode_png(
    pixels: NDArray[np.uint8] | NDArray[np.uint16], *, optimize: bool = False, text: Mapping[str, str] | None = None
) -> bytes:
    """Return a PNG file; equal pixels give equal bytes. pixels: (H, W) or (H, W, 3).

    optimize: whether to take longer for a smaller file, for drawings. text: the text of the file's iTXt chunks (UTF-8),
    by keyword.
    """
    from PIL import Image, PngImagePlugin

    chunks = PngImagePlugin.PngInfo()
    for keyword, content in (text or {}).items():
        chunks.add_itxt(keyword, content)
    if optimize:
        stream = io.BytesIO()
        Image.fromarray(pixels).save(stream, "PNG", pnginfo=chunks, optimize=True)
        return stream.getvalue()
    height, width = pixels.shape[:2]
    depth, colour = 8 * pixels.itemsize, 2 if pixels.ndim == 3 else 0
    texts = [(chunk[0], chunk[1]) for chunk in chunks.chunks]
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    parts = [(b"IHDR", header), *texts, (b"IDAT", _deflated(pixels)), (b"IEND", b"")]
    return SIGNATURE + b"".join(_chunk(kind, content) for kind, content in parts)


def _deflated(pixels: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """Return the rows of a PNG file, filtered and compressed: only by Huffman codes and runs of equal bytes.

    Pictures of water are noisy, so a search for longer matches takes 1.2 to 7 times as long and mostly gives larger
    files.
    """
    big_endian = np.ascontiguousarray(pixels, pixels.dtype.newbyteorder(">"))
    rows = big_endian.view(np.uint8).reshape(len(pixels), -1)
    pixel = rows.shape[1] // pixels.shape[1]
    lines = np.empty((len(rows), 1 + rows.shape[1]), np.uint8)
    lines[:, 0] = SUB
    lines[:, 1 : 1 + pixel] = rows[:, :pixel]
    np.subtract(rows[:, pixel:], rows[:, :-pixel], out=lines[:, 1 + pixel :])
    coder = zlib.compressobj(1, zlib.DEFLATED, zlib.MAX_WBITS, zlib.DEF_MEM_LEVEL, zlib.Z_RLE)
    return coder.compress(lines.data) + coder.flush()


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(content, zlib.crc32(kind)))


def encode_jpeg(rgb: NDArray[np.uint8], quality: int = 90) -> bytes:
    """Return a JPEG file. rgb: (H, W, 3). Raises ValueError for a quality outside [1, 100]."""
    import simplejpeg

    if not 1 <= quality <= 100:
        raise ValueError(f"quality = {quality}: must be in [1, 100]")
    return bytes(simplejpeg.encode_jpeg(np.ascontiguousarray(rgb), quality=quality))


def write_image(path: Path, rgb: NDArray[np.uint8], *, optimize: bool = False) -> None:
    """Write a .png, .jpg or .jpeg file atomically. Raises ValueError for other suffixes, OSError if writing fails."""
    check_suffix("path", path)
    is_png = path.suffix.lower() == ".png"
    write_atomically(path, encode_png(rgb, optimize=optimize) if is_png else encode_jpeg(rgb))
