"""The one error that scenario, terrain and mesh files raise, and the warning where a file was mended instead."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario or a file it names cannot be used; the message is one line that says where and what to do.

    at: keys to the value at fault, below the part of the scenario that was being built.
    """

    def __init__(self, message: str, at: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.at = at


class RepairWarning(UserWarning):
    """A file was mended before it was used; the message is one line that says what was done."""
