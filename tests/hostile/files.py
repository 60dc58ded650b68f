"""Hostile files: paths that do not name the file which a command expects."""

from __future__ import annotations

import os
import random
import re
from collections.abc import Callable
from pathlib import Path

SPARSE_BYTES = 100 << 20
SUFFIX = re.compile(r"(?<![\w.])\w*(\.(?:bt|ot|mcap|bag|png|csv|json|ya?ml|py|obj|tif|ply))\b")


def _sparse(path: Path) -> None:
    path.touch()
    os.truncate(path, SPARSE_BYTES)


def _secret(path: Path) -> None:
    path.touch()
    path.chmod(0)


FILES: dict[str, Callable[[Path], None]] = {
    "a-folder": Path.mkdir,
    "empty": Path.touch,
    "noise": lambda path: _write(path, random.Random(0).randbytes(4096)),
    "sparse": _sparse,
    "fifo": os.mkfifo,
    "loop": lambda path: path.symlink_to(path.name),
    "secret": _secret,
}
"""Functions that create the files, keyed by file stem. fifo: without a writer. secret: readable only by root."""


def make(path: Path) -> None:
    """Make the hostile file that a line names, if it names one."""
    if path.stem in FILES:
        FILES[path.stem](path)


def names(kind: type, base: str, help_text: str) -> tuple[str, ...]:
    """Return the hostile files for a parameter; none if it takes no path.

    base: a working value, "" if unknown. They have its suffix, or else the first one that the help names.
    """
    named = SUFFIX.fullmatch(base) or SUFFIX.search(help_text)
    is_path = kind is Path or (kind is str and (SUFFIX.fullmatch(base) or "file" in help_text.lower()))
    suffix = named[1] if named else ".yaml" if "YAML" in help_text else ".png" if "PNG" in help_text else ""
    return tuple(f"{name}{suffix}" for name in FILES) if is_path else ()


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)
