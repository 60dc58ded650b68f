"""Atomic writing: after an interruption, a file has either its old or its new content, never a mixture."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from uwsim.base.own_files import mark, mark_temporary, require_own

_unfinished: set[str] = set()


def remove_unfinished() -> None:
    """Remove temporary files and folders that are still being written; called before an immediate exit."""
    for name in _unfinished.copy():
        with contextlib.suppress(OSError):
            shutil.rmtree(name) if Path(name).is_dir() else Path(name).unlink()


@contextlib.contextmanager
def unfinished(folder: Path) -> Iterator[None]:
    """Have `remove_unfinished` remove a folder if the process exits immediately during the block."""
    name = str(folder)
    _unfinished.add(name)
    try:
        yield
    finally:
        _unfinished.discard(name)


def write_atomically(path: Path, content: bytes, *, replaces_any: bool = False) -> None:
    """Write a temporary file next to the target, flush it to disk and rename it.

    An existing file is replaced only if it is empty or our own (see own_files.py), unless replaces_any, for a user who
    has asked for it. On failure, raises OSError that names the target, and leaves no temporary file behind.
    """
    if path.exists() and not path.is_file() and not path.is_dir():  # a rename would replace a device
        raise OSError(f"'{path}': cannot be written: it is not a regular file")
    if not replaces_any:
        require_own(path)
    try:
        _write_and_rename(path, content)
    except OSError as error:
        raise OSError(f"'{path}': cannot be written: {error.strerror or error}") from error


def _write_and_rename(path: Path, content: bytes) -> None:
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    _unfinished.add(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            mark_temporary(descriptor)
            os.fchmod(file.fileno(), 0o644)
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
        mark(path)
    except BaseException:
        with contextlib.suppress(OSError):  # report the first error, not this one
            Path(name).unlink()
        raise
    finally:
        _unfinished.discard(name)
