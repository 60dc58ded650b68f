"""NumPy archives from strangers."""

from __future__ import annotations

import io
import threading
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAX_BYTES = 1_000_000_000
"""The most that an archive may unpack to: a few kilobytes can stand for all memory."""

_READING = threading.Lock()  # NumPy parses headers by ast, which threads of Python 3.11 disturb (CPython issue 106905)


def read_npz(source: Path | bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of an .npz file, or of its bytes, by name. Raises ValueError if it is none, OSError."""
    data = source if isinstance(source, bytes) else source.read_bytes()
    try:
        with _READING, np.load(io.BytesIO(data), allow_pickle=False) as file:
            parts = file.zip.infolist()
            if parts and min(part.header_offset for part in parts) > 0:
                raise ValueError("another file comes before it")  # which is what is left if it is cut short
            size = sum(part.file_size for part in parts)
            if size > MAX_BYTES:
                raise ValueError(f"unpacks to {size} bytes, must be {MAX_BYTES} at most")
            return {name: np.asarray(file[name]) for name in file.files}
    except Exception as error:  # a damaged archive can make NumPy, zipfile and zlib raise anything
        raise ValueError(f"is damaged, or no .npz file: {error}") from None
