"""The reader of CSV: a line of column names, then rows."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.caught_warnings import warn_if_cut_short
from uwsim.base.named import did_you_mean
from uwsim.base.texts.text_file import decoded, read_limited

MOST_BYTES = 1 << 28
MOST_CELLS = 20_000_000  # which take up to 2 GB


@dataclass(frozen=True, eq=False)
class CsvTable:
    """A table. name: the file's name, for messages. columns: their names. Its columns are converted on request."""

    name: str
    columns: tuple[str, ...]
    _rows: list[list[str]] = field(repr=False)
    _lines: list[int] = field(repr=False)

    def __len__(self) -> int:
        return len(self._rows)

    def line(self, row: int) -> int:
        """Return the file's line, counted from 1, on which a row ends."""
        return self._lines[row]

    def texts(self, column: str) -> list[str]:
        """Return the cells of a column. Raises ValueError if there is none of this name."""
        if column not in self.columns:
            hint = did_you_mean(column, self.columns)
            raise ValueError(f"{self.name}: no column '{column}'; there are: {', '.join(self.columns)}{hint}")
        index = self.columns.index(column)
        return [row[index] for row in self._rows]

    def numbers(self, column: str, *, may_lack: bool = False) -> Floats:
        """Return the finite numbers of a column, (rows,). Raises ValueError with the line of any other cell.

        may_lack: return NaN for cells that are empty or NaN.
        """
        cells = self.texts(column)
        with suppress(ValueError):  # the loop below finds the cell, and what may lack
            whole = np.array([float(cell) for cell in cells])
            if np.isfinite(whole).all() and "_" not in "".join(cells):  # float() reads 1_0 as 10
                return whole
        values = [math.nan] * len(cells)
        for k, cell in enumerate(cells):
            try:
                values[k] = math.inf if "_" in cell else float(cell)
            except ValueError:
                values[k] = math.nan if not cell.strip() else math.inf
            if not math.isfinite(values[k]) and not (may_lack and math.isnan(values[k])):
                rule = "must be a finite number" + (", or empty" if may_lack else "")
                raise ValueError(f"{self.name}:{self.line(k)}: {column} = {cell!r:.40}: {rule}")
        return np.array(values, np.float64)


def read_csv(path: Path, name: str = "", *, data: bytes | None = None) -> CsvTable:
    """Read a table. name: the file's name, for messages. data: the file's content, if it is at hand.

    Empty lines, and lines that begin with #, are left out. Warns if the last line has no end. Raises ValueError with
    name, line and rule: also for no rows, rows of another length and columns of the same name.
    """
    name = name or str(path)
    content = read_limited(path, name, MOST_BYTES) if data is None else data
    text = decoded(content, name, "CSV text")
    warn_if_cut_short(name, content)
    numbers: list[int] = []  # the line of each line that is passed on
    reader = csv.reader(_lines(text, numbers), strict=True)
    columns: tuple[str, ...] = ()
    rows: list[list[str]] = []
    lines: list[int] = []
    try:
        for row in reader:
            line = numbers[-1]
            if not columns:
                columns = tuple(cell.strip() for cell in row)
                repeated = [column for k, column in enumerate(columns) if column in columns[:k]]
                if repeated:
                    raise ValueError(f"{name}:{line}: column '{repeated[0]}' is named twice")
                continue
            if len(row) != len(columns):
                raise ValueError(f"{name}:{line}: {len(row)} values: must be {len(columns)}, one for each column")
            rows.append(row)
            lines.append(line)
            if len(rows) * len(columns) > MOST_CELLS:
                raise ValueError(f"{name}: must have at most {MOST_CELLS} values")
    except csv.Error as error:
        raise ValueError(f"{name}:{numbers[-1] if numbers else 1}: not CSV ({error})") from None
    if not rows:
        raise ValueError(f"{name}: has no rows under column names")
    return CsvTable(name, columns, rows, lines)


def _lines(text: str, numbers: list[int]) -> Iterator[str]:
    for number, line in enumerate(io.StringIO(text, newline=None), start=1):
        stripped = line.strip()
        if stripped and not stripped.startswith("#"):
            numbers.append(number)
            yield line
