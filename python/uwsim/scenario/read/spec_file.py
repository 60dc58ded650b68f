"""Reads the YAML files of a scenario and of its parts, cached and with line numbers, and thrusters' sheets."""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel

from uwsim.base.texts import yaml_document
from uwsim.base.texts.csv_table import read_csv
from uwsim.base.texts.text_file import read_limited
from uwsim.base.texts.yaml_document import Key, YamlDocument, dotted
from uwsim.scenario.read.assets import find_yaml, shown_name
from uwsim.scenario.read.disk_cache import cached_json
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.validated import validated


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


def read_yaml(path: Path, name: str) -> YamlDocument:
    """Read a YAML mapping. name: the file's name, for messages. Raises ScenarioError with name and line."""
    try:
        return yaml_document.read_yaml(path, name, lambda text, name: copy.deepcopy(_values(text, name)))
    except ValueError as error:
        raise ScenarioError(str(error)) from None


@functools.lru_cache(maxsize=64)  # files rarely change
def _values(text: str, name: str) -> dict[str, Any]:
    """Return a document's content, which must not be modified."""

    def parse() -> dict[str, Any]:
        from uwsim.base.texts.yaml_parser import plain_values

        return plain_values(text, name)

    values: dict[str, Any] = cached_json(parse, "yaml", text)
    return values


Spec = TypeVar("Spec", bound=BaseModel)


def read_spec(model: type[Spec], source: str | Path, kind: str, folder: Path | None = None) -> Spec:
    """Read and validate the YAML file of a packaged name or a path. Raises ScenarioError.

    kind: the assets folder in which packaged names are found, such as "vehicles". folder: the base of relative paths,
    by default the working folder.
    """
    path = spec_path(source, kind, folder)
    document = read_yaml(path, shown_name(path))
    spec = validated(model, document.values, document, folder=path.resolve().parent)
    if "_source_file" in spec.__private_attributes__:
        spec._source_file = SourceFile(document)  # type: ignore[attr-defined]
    return spec


def spec_path(source: str | Path, kind: str, folder: Path | None = None) -> Path:
    """Return the YAML file that read_spec reads. Raises ScenarioError if there is none."""
    beside = (folder or Path()) / source
    return beside if beside.is_file() else find_yaml(source, kind)


MAX_BYTES = 1_000_000


class SheetRow(NamedTuple):
    """A point on a performance sheet. command: the command, in the unit of the thruster's own table."""

    voltage_v: float
    command: float
    thrust_n: float
    current_a: float
    rpm: float


def read_sheet_rows(path: Path) -> list[SheetRow]:
    """Return the rows of a CSV file with the columns of SheetRow, in this order. Raises ScenarioError."""
    name = shown_name(path)
    try:
        table = read_csv(path, name, data=read_limited(path, name, MAX_BYTES))
        if table.columns != SheetRow._fields:
            raise ValueError(f"{name}: must begin with {','.join(SheetRow._fields)}")
        return [SheetRow(*row) for row in zip(*(table.numbers(c).tolist() for c in table.columns), strict=True)]
    except ValueError as error:
        raise ScenarioError(str(error)) from None
