"""Encoding and writing of PNG and JPEG files."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically

SUFFIXES = (".png", ".jpg", ".jpeg")
RUNS: Mapping[str, Any] = {"compress_level": 1, "compress_type": 3}
"""Options of PNG files: Huffman codes and runs of equal bytes only (zlib's Z_RLE). Pictures of water are noisy, so a
search for longer matches takes 1.2 to 7 times as long and mostly gives larger files."""


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
    stream = io.BytesIO()
    options = {"optimize": True} if optimize else RUNS
    Image.fromarray(pixels).save(stream, "PNG", pnginfo=chunks, **options)
    return stream.getvalue()


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
