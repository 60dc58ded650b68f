"""Warns about truncated text files, in which the last number may have lost its final digits."""

from __future__ import annotations

import warnings


def warn_if_cut_short(name: str, content: bytes) -> None:
    """Warn if a text file does not end in a line break, as after an aborted download. name: the file's name."""
    if content and not content.endswith((b"\n", b"\r")):
        end = content.rstrip()[-20:].decode("utf-8", errors="replace").split("\n")[-1]
        warnings.warn(
            f"{name}: its last line, '...{end}', does not end in a line break: the file may be cut short", stacklevel=3
        )
