"""Collected: gathers errors from parts that are built one by one, so that they can be reported together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from uwsim.scenario.read.errors import ScenarioError


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
