"""Reads a thruster's measured performance at several supply voltages from a CSV file."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from uwsim.base.texts.csv_table import read_csv
from uwsim.base.texts.text_file import read_limited
from uwsim.scenario.read.assets import shown_name
from uwsim.scenario.read.errors import ScenarioError

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
