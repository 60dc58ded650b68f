"""Collected: gathers the errors of parts that are built one by one, to report them together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from uwsim.scenario.read.errors import ScenarioError


class Collected:
    """The mistakes found so far, each one line."""

    def __init__(self) -> None:
        self.mistakes: list[str] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Catch and note a ScenarioError raised in the block."""
        try:
            yield
        except ScenarioError as error:
            self.mistakes += error.mistakes

    def raise_any(self) -> None:
        """Raise one ScenarioError with all mistakes, if there are any."""
        if self.mistakes:
            raise ScenarioError.of(self.mistakes)
