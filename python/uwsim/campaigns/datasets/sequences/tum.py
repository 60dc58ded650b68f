"""Tum: a trajectory in TUM's format, as evo reads it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


class Tum:
    """A file that grows pose by pose; world ENU."""

    def __init__(self, path: Path) -> None:
        """Create the file. Raises OSError."""
        self._file = path.open("w", newline="\n")
        self._file.write("# timestamp tx ty tz qx qy qz qw\n")

    def add(self, time_ns: int, position_m: Iterable[float], orientation_xyzw: Iterable[float]) -> None:
        """Append a pose; numbers are written so that they read back unchanged. Raises OSError."""
        seconds, rest_ns = divmod(time_ns, 1_000_000_000)
        self._file.write(" ".join([f"{seconds}.{rest_ns:09d}", *map(repr, (*position_m, *orientation_xyzw))]) + "\n")

    def close(self) -> None:
        """Close the file. Raises OSError."""
        self._file.close()
