"""Which file a scenario was read from, so that what is found out later is told with its line too."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from uwsim.scenario.document import Document, Key
from uwsim.scenario.errors import ScenarioError


@dataclass(frozen=True)
class Origin:
    """document: None for a scenario made in Python. All origins are equal: they are no part of a scenario."""

    document: Document | None = field(default=None, compare=False, repr=False)

    def where(self, *path: Key) -> str:
        """`lake.yaml:12: `, or nothing."""
        return f"{self.document.name}:{self.document.line(path)}: " if self.document else ""

    @contextmanager
    def place(self, *path: Key) -> Iterator[None]:
        """ScenarioErrors raised inside begin with the file and the line of the value at fault, at or below path."""
        try:
            yield
        except ScenarioError as error:
            raise ScenarioError(self.where(*path, *error.at) + str(error)) from None
