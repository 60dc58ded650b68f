"""The common error for scenario, terrain and mesh files, warnings about repaired files, and collected errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager


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


class Collected:
    """The mistakes found so far, one line each."""

    def __init__(self) -> None:
        self.mistakes: list[str] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Catch a ScenarioError raised in the block and record its mistakes, but for one that came up elsewhere."""
        try:
            yield
        except ScenarioError as error:
            known = tuple(each.partition(": ")[2] or each for each in self.mistakes)
            self.mistakes += [each for each in error.mistakes if not each.endswith(known)]

    def raise_any(self) -> None:
        """Raise one ScenarioError with all recorded mistakes, if there are any."""
        if self.mistakes:
            raise ScenarioError.of(self.mistakes)
