"""Reader: a kind of file that others write, known by its content. The readers of one purpose are entry points.

A group, such as `uwsim.kinds.cast`, is asked in order, uwsim's own first; docs/inside/extend.md adds one.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from uwsim.base import sockets
from uwsim.base.texts.text_file import first_bytes

HEAD_BYTES = 1 << 14


@dataclass(frozen=True)
class Reader:
    """A kind of file or folder. what: for messages, such as `a URDF file`. options: of the command line, that it takes.

    accepts: whether a path with these first bytes (of a folder none) looks like one, at little cost. read: called with
    what its group states; raises ValueError or OSError.
    """

    what: str
    accepts: Callable[[Path, bytes], bool]
    read: Callable[..., Any]
    options: tuple[str, ...] = ()


def readers(group: str) -> Mapping[str, Reader]:
    """Return a group's readers by name. Warns of those that cannot be used."""
    return sockets.load_all(group, _reader)


def head_of(path: Path) -> bytes:
    """Return the first bytes of a file, none of a folder. Raises OSError."""
    return b"" if path.is_dir() else first_bytes(path, HEAD_BYTES)


def reader_of(group: str, path: Path) -> Reader | None:
    """Return the first reader of a group that accepts a path, or None. Raises OSError."""
    head = head_of(path)
    for name, reader in readers(group).items():
        try:
            with sockets.blaming(group, name, "accepts"):
                if not reader.accepts(path, head):
                    continue
        except sockets.EntryError as error:
            warnings.warn(f"{error}; not asked further", sockets.SocketWarning, stacklevel=2)
            continue

        def read(*arguments: Any, name: str = name, reader: Reader = reader) -> Any:
            with sockets.blaming(group, name, "read", (ValueError, OSError)):
                return reader.read(*arguments)

        return replace(reader, read=read)
    return None


def _reader(name: str, found: object) -> Reader:
    if not isinstance(found, Reader):
        raise TypeError(f"{name}: must be a {Reader.__module__}.Reader")
    return found
