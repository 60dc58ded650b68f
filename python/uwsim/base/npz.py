"""NumPy archives: their content as bytes, and a reader for untrusted ones."""

from __future__ import annotations

import io
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.texts.text_file import require_regular

MAX_BYTES = 1_000_000_000
"""The largest unpacked size accepted: an archive of a few kilobytes can expand to fill all memory."""

_READING = threading.Lock()  # NumPy parses headers with ast: not thread-safe in Python 3.11 (CPython issue 106905)


def npz_bytes(save: Callable[..., None] = np.savez_compressed, /, **arrays: Any) -> bytes:
    """Return the content of an .npz file; equal arrays give equal bytes. save: np.savez for one without compression."""
    content = io.BytesIO()
    save(content, allow_pickle=False, **arrays)
    return content.getvalue()


def read_npz(source: Path | bytes, most_bytes: int = MAX_BYTES) -> dict[str, NDArray[Any]]:
    """Return the arrays in an .npz file, keyed by name. Raises ValueError if the file is invalid, or OSError.

    source: the path of the file, or its content. most_bytes: the largest unpacked size.
    """
    data = source if isinstance(source, bytes) else require_regular(source).read_bytes()
    try:
        with _READING, np.load(io.BytesIO(data), allow_pickle=False) as file:
            parts = file.zip.infolist()
            if parts and min(part.header_offset for part in parts) > 0:
                raise ValueError("another file comes before it")  # as in an archive that lacks its beginning
            size = sum(part.file_size for part in parts)
            if size > most_bytes:
                raise ValueError(f"unpacks to {size} bytes, must be {most_bytes} at most")
            return {name: np.asarray(file[name]) for name in file.files}
    except Exception as error:  # a damaged archive can make NumPy, zipfile and zlib raise anything
        raise ValueError(f"is damaged, or not an .npz file: {error}") from None
