"""Atomic writing: after an interruption, a file has either its old or its new content, never a mixture."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
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


def write_atomically(path: Path, content: bytes, *, replaces_any: bool = False, flushes: bool = True) -> None:
    """Write a temporary file next to the target, flush it to disk and rename it.

    An existing file is replaced only if it is empty or our own (see own_files.py), unless replaces_any, for a user who
    has asked for it. flushes: False for a file that its reader checks and makes again: flushing takes milliseconds, and
    a loss of power may otherwise leave a damaged file. On failure, raises OSError that names the target, and leaves no
    temporary file behind.
    """
    file = GrowingFile(path, replaces_any=replaces_any)
    try:
        file.write(content)
        file.close(flushes=flushes)
    except BaseException:  # report the first error, not one of discarding
        file.discard()
        raise


class GrowingFile:
    """A file that is written piece by piece, as a temporary file next to its target, and is renamed by `close`.

    replaces_any: see write_atomically. The methods and the constructor raise OSError that names the target.
    """

    def __init__(self, path: Path, *, replaces_any: bool = False) -> None:
        if path.exists() and not path.is_file() and not path.is_dir():  # a rename would replace a device
            raise OSError(f"'{path}': cannot be written: it is not a regular file")
        if not replaces_any:
            require_own(path)
        self._path = path
        with self._named():
            self._name = str(path.parent / f".{path.name}.{secrets.token_hex(4)}")
            self._file = Path(self._name).open("xb")  # noqa: SIM115  # mkstemp would ignore the umask
            _unfinished.add(self._name)
            mark_temporary(self._file.fileno())

    def write(self, content: bytes) -> int:
        """Append bytes; return their number."""
        with self._named():
            return self._file.write(content)

    def close(self, *, flushes: bool = True) -> None:
        """Flush the content to disk, unless not `flushes`, and rename the file to its target."""
        with self._named(), self._file as file:
            file.flush()
            if flushes:
                os.fsync(file.fileno())
        with self._named():
            Path(self._name).replace(self._path)
            mark(self._path)
        _unfinished.discard(self._name)

    def discard(self) -> None:
        """Remove the temporary file, if it has not been renamed. Raises nothing."""
        with contextlib.suppress(OSError):
            self._file.close()
        if self._name in _unfinished:
            with contextlib.suppress(OSError):
                Path(self._name).unlink()
            _unfinished.discard(self._name)

    @contextlib.contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise OSError(f"'{self._path}': cannot be written: {error.strerror or error}") from error
