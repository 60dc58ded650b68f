"""SourceFile: the file that a scenario was read from, so that later errors can still name file and line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.yaml_document import Key, YamlDocument, dotted


@dataclass(frozen=True)
class SourceFile:
    """document: None for a scenario made in Python. All source files compare equal: a scenario does not depend on them.

    in_file: maps a place in the scenario to the place in the file, if parts of the file were left out.
    """

    document: YamlDocument | None = field(default=None, compare=False, repr=False)
    in_file: Callable[[Sequence[Key]], Sequence[Key]] = field(default=tuple, compare=False, repr=False)

    def line_prefix(self, *keys: Key) -> str:
        """Return `lake.yaml:12: ` for the value under these keys, or an empty string."""
        return f"{self.document.name}:{self.document.line(self.in_file(keys))}: " if self.document else ""

    def place(self, *keys: Key) -> str:
        """Return the keys in the form used in messages: vehicles[0].model."""
        return dotted(self.in_file(keys))

    @property
    def file_prefix(self) -> str:
        """Return `lake.yaml: `, or an empty string."""
        return f"{self.document.name}: " if self.document else ""

    @contextmanager
    def errors_at(self, *keys: Key) -> Iterator[None]:
        """Prefix ScenarioErrors from the block with file and line; the value at fault is at or below these keys."""
        try:
            yield
        except ScenarioError as error:
            prefix = self.line_prefix(*keys, *error.at)
            raise ScenarioError.of([prefix + mistake for mistake in error.mistakes]) from None
