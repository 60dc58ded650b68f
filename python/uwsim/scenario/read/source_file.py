"""SourceFile: the file from which a scenario was read, so that later errors can name the file and line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from uwsim.base.texts.yaml_document import Key, YamlDocument, dotted
from uwsim.scenario.read.errors import ScenarioError


@dataclass(frozen=True)
class SourceFile:
    """The file from which a scenario was read, for error messages.

    document: None for a scenario built in Python. in_file: converts a position in the scenario to the position in the
    file; they differ if parts of the file were left out. All source files compare equal, so that they do not affect the
    equality of scenarios.
    """

    document: YamlDocument | None = field(default=None, compare=False, repr=False)
    in_file: Callable[[Sequence[Key]], Sequence[Key]] = field(default=tuple, compare=False, repr=False)

    def line_prefix(self, *keys: Key) -> str:
        """Return `lake.yaml:12: ` for the value under these keys, or an empty string.

        Without the line if no memory is left to find it, which the message may be about.
        """
        if self.document is None:
            return ""
        try:
            return f"{self.document.name}:{self.document.line(self.in_file(keys))}: "
        except Exception:  # without memory, an import raises anything, such as SyntaxError
            return self.file_prefix

    def place(self, *keys: Key) -> str:
        """Return the keys in the notation of messages: vehicles[0].model."""
        return dotted(self.in_file(keys))

    @property
    def file_prefix(self) -> str:
        """Return the file name as a prefix of messages, such as `lake.yaml: `, or an empty string without a file."""
        return f"{self.document.name}: " if self.document else ""

    @contextmanager
    def errors_at(self, *keys: Key) -> Iterator[None]:
        """Prefix ScenarioErrors from the block with the file and line of the offending value at or below these keys."""
        try:
            yield
        except ScenarioError as error:
            prefix = self.line_prefix(*keys, *error.at)
            raise ScenarioError.of([prefix + mistake for mistake in error.mistakes]) from None
