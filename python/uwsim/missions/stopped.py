"""The exception that ends a mission early."""

from __future__ import annotations


class StoppedError(Exception):
    """The mission ended early; the message states the reason, such as "stuck 3 m before (10, 20, -5) m"."""
