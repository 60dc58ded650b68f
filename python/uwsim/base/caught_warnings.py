"""Warnings: caught in code that runs in several threads, and issued about truncated text files."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock

_ONE_THREAD = RLock()


@contextmanager
def caught_warnings() -> Iterator[list[warnings.WarningMessage]]:
    """Collect the warnings issued in the block, which only one thread may enter at a time.

    The filters and the hook are global to the process, and each block restores those that it found. If two blocks
    overlapped, the filters of the first would stay in place, and the process would no longer show warnings.
    """
    with _ONE_THREAD, warnings.catch_warnings(record=True) as issued:
        warnings.simplefilter("always")
        yield issued


def warn_if_cut_short(name: str, content: bytes) -> None:
    """Warn if a text file does not end in a line break, as after an aborted download. name: the file's name."""
    if content and not content.endswith((b"\n", b"\r")):
        end = content.rstrip()[-20:].decode("utf-8", errors="replace").split("\n")[-1]
        warnings.warn(
            f"{name}: its last line, '...{end}', does not end in a line break: the file may be cut short", stacklevel=3
        )
