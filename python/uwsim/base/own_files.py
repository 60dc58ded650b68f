"""Own files: marks every file that uwsim writes, and recognizes it, so that no other file is deleted or replaced.

The mark is the extended attribute user.uwsim. It contains the file's size and time of modification, so that a file that
was changed afterwards, or copied over ours, is recognized as foreign. On a file system without extended attributes, the
marks are lines of a file in the folder.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from pathlib import Path

MARK, UNFINISHED = "user.uwsim", b"unfinished"
"""The attribute, and its value while a file or folder is being written; also set by cpp/uwsim/mapping/atomic_file."""
LIST = ".uwsim.written"
"""The file with the marks, where attributes are not supported: lines of a mark and a name, of which the last counts."""


def mark(path: Path, *, unfinished: bool = False) -> None:
    """Mark a file that uwsim has written; unfinished: that it, or a folder, is still being written."""
    with contextlib.suppress(OSError):  # a file without a mark is merely never replaced
        value = UNFINISHED if unfinished else _signature(path.lstat())
        try:
            os.setxattr(path, MARK, value, follow_symlinks=False)
        except OSError as error:
            if error.errno != errno.ENOTSUP:
                raise
            with (path.parent / LIST).open("ab") as file:
                file.write(value + b" " + os.fsencode(path.name) + b"\n")


def mark_temporary(descriptor: int) -> None:
    """Mark a temporary file, so that it is recognized if the process is killed."""
    with contextlib.suppress(OSError):
        os.setxattr(descriptor, MARK, UNFINISHED)


def is_own(path: Path) -> bool:
    """Return whether uwsim wrote this file, or created this folder, and the file has not changed since."""
    try:
        found = path.lstat()
    except OSError:
        return False
    value = _mark_of(path)
    return value == UNFINISHED or (not stat.S_ISDIR(found.st_mode) and value == _signature(found))


def require_own(path: Path) -> None:
    """Raise FileExistsError if a path cannot be written without loss: its file is neither empty nor our own."""
    if os.path.lexists(path) and not path.is_dir() and not is_empty(path) and not is_own(path):
        raise FileExistsError(
            f"'{path}': exists, and uwsim did not write it as it is: choose another name, or remove it first"
        )


def remove_own_file(path: Path) -> None:
    """Remove a file, if there is one. Raises FileExistsError for one that is not our own, or OSError."""
    require_own(path)
    path.unlink(missing_ok=True)


def remove_own(folder: Path) -> list[Path]:
    """Remove our own files in a folder, and then the folder if it is empty; return the paths that are left.

    Raises OSError.
    """
    left = []
    for path in sorted(folder.iterdir()):
        if path.name == LIST:
            continue
        if path.is_dir() and not path.is_symlink():
            left += remove_own(path)
        elif is_own(path):
            path.unlink()
        else:
            left.append(path)
    if not left:
        (folder / LIST).unlink(missing_ok=True)
        folder.rmdir()
    return left


def is_empty(path: Path) -> bool:
    """Return whether a path is a regular file without content, which can be replaced without loss. Raises OSError."""
    found = path.lstat()
    return stat.S_ISREG(found.st_mode) and found.st_size == 0


def _signature(found: os.stat_result) -> bytes:
    return b"%d bytes, modified %d ns" % (found.st_size, found.st_mtime_ns)


def _mark_of(path: Path) -> bytes | None:
    with contextlib.suppress(OSError):
        return os.getxattr(path, MARK, follow_symlinks=False)
    ending = b" " + os.fsencode(path.name)
    try:
        lines = (path.parent / LIST).read_bytes().splitlines()
    except OSError:
        return None
    return next((line.removesuffix(ending) for line in reversed(lines) if line.endswith(ending)), None)
