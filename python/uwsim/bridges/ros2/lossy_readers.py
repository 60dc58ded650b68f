"""LossyReaders: warns of best-effort readers whose sockets cannot hold a topic's messages.

A best-effort reader does not request what it has missed. A message of many packets, such as a depth picture of 1.2 MB,
overflows a socket with Linux's default buffer of 213 kB, and is then lost as a whole.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

DEFAULT = Path("/proc/sys/net/core/rmem_default")
ADVICE = "sudo sysctl -w net.core.rmem_default=4194304 net.core.rmem_max=4194304"


def default_buffer_bytes() -> int | None:
    """Return the size of a socket's receive buffer on this machine unless a program asks for more, or None."""
    try:
        return int(DEFAULT.read_text())
    except (OSError, ValueError):
        return None


class LossyReaders:
    """The topics that have best-effort readers. warn: called once for each topic whose messages are too large."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self._buffer_bytes = default_buffer_bytes()
        self._topics: set[str] = set()
        self._warned: set[str] = set()

    def note(self, topic: str, has_best_effort_readers: bool) -> None:
        """Record whether a topic has best-effort readers. Called when its readers have changed."""
        (self._topics.add if has_best_effort_readers else self._topics.discard)(topic)

    def check(self, topic: str, size_bytes: int) -> None:
        """Warn if a message is too large for the topic's readers."""
        buffer_bytes = self._buffer_bytes
        if topic not in self._topics or topic in self._warned or buffer_bytes is None or size_bytes <= buffer_bytes:
            return
        self._warned.add(topic)
        self._warn(
            f"topic '{topic}': a best-effort reader will lose messages of {size_bytes / 1e3:.0f} kB, since sockets "
            f"buffer {buffer_bytes / 1e3:.0f} kB: subscribe with reliable QoS, or {ADVICE}"
        )
