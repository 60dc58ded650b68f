"""The bytes and the text of a file that may come from anywhere."""

from __future__ import annotations

import errno
import stat
from pathlib import Path


def require_regular(path: Path) -> Path:
    """Return a path. Raises OSError for a device, socket or FIFO, which could be read for ever, before it is opened."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise OSError(errno.EINVAL, "it is no regular file", str(path))
    return path


def first_bytes(path: Path, count: int) -> bytes:
    """Return the first bytes of a file. Raises OSError."""
    with require_regular(path).open("rb") as file:
        return file.read(count)


def read_limited(path: Path, name: str, most_bytes: int) -> bytes:
    """Return a file's bytes. name: the file's name, for messages. Raises ValueError, also for an unreadable file."""
    try:
        with require_regular(path).open("rb") as file:
            data = file.read(most_bytes + 1)  # not the size alone: those of /proc are 0
            size = max(path.stat().st_size, len(data))
    except OSError as error:
        raise ValueError(f"{name}: cannot be read: {error.strerror}") from None
    if size > most_bytes:
        raise ValueError(f"{name}: {size} bytes: must be at most {most_bytes}")
    return data


def decoded(data: bytes, name: str, kind: str) -> str:
    """Return UTF-8 bytes as text without a byte order mark. kind: of text, for messages. Raises ValueError."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ValueError(f"{name}:{line}: not UTF-8 text") from None
    if "\0" in text:
        raise ValueError(f"{name}: a binary file, expected {kind}")
    return text
