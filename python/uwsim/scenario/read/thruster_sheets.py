"""Reads a thruster's measured performance at several supply voltages from a CSV file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from uwsim.scenario.read.assets import shown_name
from uwsim.scenario.read.errors import ScenarioError

COLUMNS = ("voltage_v", "command", "thrust_n", "current_a", "rpm")
MAX_BYTES = 1_000_000


class SheetRow(NamedTuple):
    """A point on a performance sheet. command: the command, in the unit of the thruster's own table."""

    voltage_v: float
    command: float
    thrust_n: float
    current_a: float
    rpm: float


def read_sheet_rows(path: Path) -> list[SheetRow]:
    """Return the rows of a file with these COLUMNS; lines starting with # are comments. Raises ScenarioError."""
    name = shown_name(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ScenarioError(f"{name}: {path.stat().st_size} bytes: must be at most {MAX_BYTES}")
        lines = path.read_text("utf-8-sig").splitlines()
    except OSError as error:
        raise ScenarioError(f"{name}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{name}: not UTF-8 text") from None
    numbered = [(k, line) for k, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    if not numbered or tuple(cell.strip() for cell in numbered[0][1].split(",")) != COLUMNS:
        raise ScenarioError(f"{name}:{numbered[0][0] if numbered else 1}: must begin with {','.join(COLUMNS)}")
    return [_row(line.split(","), f"{name}:{k}") for k, line in numbered[1:]]


def _row(cells: list[str], place: str) -> SheetRow:
    if len(cells) != len(COLUMNS):
        raise ScenarioError(f"{place}: {len(cells)} values: must be {len(COLUMNS)}")
    values = []
    for column, cell in zip(COLUMNS, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ScenarioError(f"{place}: {column} = {cell.strip():.40}: must be a number")
        values.append(value)
    return SheetRow(*values)
