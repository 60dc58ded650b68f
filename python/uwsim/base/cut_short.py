"""Text files that may be cut short: the last number of "-12.5" without its end may have been -12.53."""

from __future__ import annotations

import warnings


def warn_if_cut_short(name: str, content: bytes) -> None:
    """Warn if a text file's last line has no line break, as after a broken download. name: the file, in messages."""
    if content and not content.endswith((b"\n", b"\r")):
        end = content.rstrip()[-20:].decode("utf-8", errors="replace").split("\n")[-1]
        warnings.warn(
            f"{name}: its last line, '...{end}', does not end in a line break: the file may be cut short", stacklevel=3
        )
