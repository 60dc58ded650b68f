"""A lock on an output folder, so that two runs cannot overwrite each other's files."""

from __future__ import annotations

import fcntl
import os
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LOCK = ".uwsim.lock"
"""The lock file, which names the process that holds it. The kernel releases the lock when that process ends."""


@contextmanager
def alone_in(folder: Path, option: str = "--out") -> Iterator[None]:
    """Lock a folder, which an option names, for the duration of the block.

    Raises OSError if another run has locked it or locking fails.
    """
    path = folder / LOCK
    descriptor = _locked(path, option)
    with suppress(OSError):  # disk full: the lock still works, but does not name its holder
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f"process {os.getpid()}: {shlex.join(sys.argv)[:200]}\n".encode(errors="replace"))
    try:
        yield
    finally:
        with suppress(OSError):  # the folder has vanished
            path.unlink()  # before it is released, so that a process waiting for it notices
        os.close(descriptor)


def require_free(folder: Path) -> None:
    """Raise OSError if the path is not a folder, or if another run has locked it. Called before a world is built."""
    if os.path.lexists(folder) and not folder.is_dir():
        raise OSError(f"--out {folder}: is not a folder")
    if (folder / LOCK).exists():
        with alone_in(folder):
            pass


def _locked(path: Path, option: str) -> int:
    """Lock the file and return its descriptor, after checking that the file was not unlinked in the meantime."""
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise OSError(f"{option} {path.parent}: cannot write there: {error.strerror}") from error
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if path.exists() and os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        except BlockingIOError:
            holder = " ".join(os.pread(descriptor, 300, 0).decode(errors="replace").split())
            os.close(descriptor)
            raise OSError(
                f"{option} {path.parent}: another run is using it{f' ({holder})' if holder else ''}: "
                f"choose another {option}"
            ) from None
        except OSError as error:
            os.close(descriptor)
            raise OSError(f"'{path}': cannot be locked: {error.strerror}") from error
        os.close(descriptor)
