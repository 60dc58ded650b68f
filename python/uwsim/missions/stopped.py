"""How a mission ends before its time."""

from __future__ import annotations


class StoppedError(Exception):
    """The mission ended early; the message says why, such as "stuck 3 m before (10, 20, -5) m"."""
