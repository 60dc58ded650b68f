"""The one error that scenario, terrain and mesh files raise, and the warning about a file that was repaired."""

from __future__ import annotations

from collections.abc import Sequence


class ScenarioError(ValueError):
    """A scenario, or a file that it names, cannot be used. The message is one line: where, and what to do.

    at: keys to the value at fault, below the part of the scenario that was being built. mistakes: the message of each,
    if a file has several; the error's own message is the first, the others are its notes, which tracebacks show.
    """

    def __init__(self, message: str, at: tuple[str | int, ...] = (), mistakes: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.at = at
        self.mistakes = tuple(mistakes) or (message,)

    @classmethod
    def of(cls, mistakes: Sequence[str]) -> ScenarioError:
        """Make one error of several mistakes."""
        error = cls(mistakes[0], mistakes=mistakes)
        for other in mistakes[1:]:
            error.add_note(other)
        return error


class RepairWarning(UserWarning):
    """A file was repaired before it was used. The message is one line that says what was done."""
