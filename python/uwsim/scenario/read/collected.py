"""Collects the errors of parts that are built one by one, so that they are reported all at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from uwsim.scenario.read.errors import ScenarioError


class Collected:
    """The mistakes so far, each one line."""

    def __init__(self) -> None:
        self.mistakes: list[str] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Note the ScenarioError that is raised inside, and go on after it."""
        try:
            yield
        except ScenarioError as error:
            self.mistakes += error.mistakes

    def raise_any(self) -> None:
        """Raise one ScenarioError of all mistakes, if there are some."""
        if self.mistakes:
            raise ScenarioError.of(self.mistakes)
