"""The one error that scenario, terrain and mesh files raise, and the warning about a file that was repaired."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario, or a file that it names, cannot be used. The message is one line: where, and what to do.

    at: keys to the value at fault, below the part of the scenario that was being built.
    """

    def __init__(self, message: str, at: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.at = at


class RepairWarning(UserWarning):
    """A file was repaired before it was used. The message is one line that says what was done."""
