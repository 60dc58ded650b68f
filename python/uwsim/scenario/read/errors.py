"""The common error for scenario, terrain and mesh files, and the warning about repaired files."""

from __future__ import annotations

from collections.abc import Sequence


class ScenarioError(ValueError):
    """A scenario, or a file that it names, cannot be used. The message is one line: the location and the remedy.

    at: key path of the offending value, relative to the part of the scenario being built. mistakes: all messages, if
    there are several; the first is this exception's own message, the rest are attached as notes and shown in
    tracebacks.
    """

    def __init__(self, message: str, at: tuple[str | int, ...] = (), mistakes: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.at = at
        self.mistakes = tuple(mistakes) or (message,)

    @classmethod
    def of(cls, mistakes: Sequence[str]) -> ScenarioError:
        """Return one error for several mistakes."""
        error = cls(mistakes[0], mistakes=mistakes)
        for other in mistakes[1:]:
            error.add_note(other)
        return error


class RepairWarning(UserWarning):
    """Issued when a file was repaired before use. The message describes the repair in one line."""


class CastWarning(UserWarning):
    """Issued where a cast is not used as a whole, or lacks what is assumed instead. The message is one line."""
