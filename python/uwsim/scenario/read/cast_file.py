"""Casts, the measured columns of water that survey and oceanography have: files of sound speed, temperature, salinity.

A file is recognised by its content, by a reader of the group GROUP: CARIS (.svp), Kongsberg (.asvp), Sea-Bird (.cnv, as
text), Sippican (.edf), Argo (NetCDF), the Valeport probes that do not name their columns. Else it is any table whose
columns have names: those of AML, Valeport, Digibar, CastAway, SAIV, Idronaut, ELAC, Sea & Sun, WHP-Exchange, or a CSV.
Rows of two numbers without names are depth and speed of sound. Columns are separated by commas, semicolons, tabs or
spaces; decimals may have commas where these do not separate. Lines without numbers after the last row are a trailer.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.caught_warnings import warn_if_cut_short
from uwsim.base.reader import reader_of
from uwsim.base.texts.text_file import read_limited
from uwsim.scenario.read.cast_levels import PRESSURE, Cast, Columns, Limits, levels_of, quantity_of, unit_of

Floats = NDArray[np.float64]
GROUP = "uwsim.kinds.cast"
"""Each reader returns the Columns of a path and of the file's name for messages."""
MOST_BYTES = 1 << 27
NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?")
COMMENT = ("#", "%", "*", "!", "//")
OFF_SCALE = -99.0, -2.53, 35.5
"""Sippican's marks: no value, and the ends of its thermistor's scale, where a torn or grounded wire is."""
MISSING, BAD_FLAGS = (-999.0,), ("3", "4", "5", "9")
"""WHP-Exchange's marks (Swift and Diggs 2008): no value; flags for questionable, bad, not reported, not sampled."""


class CastTable(NamedTuple):
    """labels: names of columns. units: of the columns, where a line below the names has them. rows: line and cells."""

    labels: Sequence[str]
    units: Sequence[str]
    rows: Sequence[tuple[int, Sequence[str]]]
    notes: Sequence[str] = ()
    bad: Sequence[float] = ()


def read_cast(path: Path, name: str = "", limits: Limits | None = None) -> Cast:
    """Read a cast. name: the file's name, for messages. Raises ValueError with name, line and rule.

    limits: what every value below the surface must be in.
    """
    name = name or str(path)
    read_limited(path, name, MOST_BYTES)
    reader = reader_of(GROUP, path)
    columns: Columns = (_table if reader is None else reader.read)(path, name)
    return levels_of(name, columns.values, columns.lines, columns.notes, limits or {})


def _table(path: Path, name: str) -> Columns:
    lines = cast_lines(path, name)
    table = _columns(lines) or _pairs(lines)
    if table is None:
        raise ValueError(
            f"{name}: not a cast: no line names its columns, depth or pressure and sound speed or temperature, and its "
            "rows are not two numbers, depth and sound speed: give it a line such as depth_m,sound_speed_m_s above them"
        )
    return numbers_of(name, table)


def cast_lines(path: Path, name: str) -> list[str]:
    """Return the lines of a cast that is text. Raises ValueError."""
    data = read_limited(path, name, MOST_BYTES)
    lines = lines_of(data)
    if any("\0" in line for line in lines):
        raise ValueError(f"{name}: a binary file, expected a cast as text or NetCDF")
    warn_if_cut_short(name, data)
    return lines


def lines_of(data: bytes) -> list[str]:
    """Return the lines of bytes in any of the encodings that casts have."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = data.decode("utf-16", "replace")
    else:
        try:
            text = data.removeprefix(b"\xef\xbb\xbf").decode()
        except UnicodeDecodeError:
            text = data.decode("latin-1")
    return io.StringIO(text, newline=None).read().split("\n")


def cells_of(line: str) -> list[str]:
    """Return a line's cells, separated by what it has: tabs, semicolons, commas or spaces."""
    for separator in "\t;":
        if separator in line:
            return [cell.strip().strip('"') for cell in line.split(separator)]
    words = line.split()
    if "," in line and not (len(words) > 1 and all(NUMBER.fullmatch(word) for word in words)):
        return [cell.strip().strip('"') for cell in line.split(",")]
    return words


def _named_cells(line: str) -> list[str]:
    """Return the cells of a line if they name the columns of a cast, else none."""
    text = _bare(line).removeprefix("Columns=")
    if not set("\t,;") & set(text):
        text = text.replace(" - ", "\t") if " - " in text else re.sub(r"\s+([\[(])", r"\1", text)
    cells = cells_of(text)
    keys = {found[0] for cell in cells if (found := quantity_of(cell))}
    is_cast = keys & {"depth_m", PRESSURE} and keys & {"temperature_deg_c", "sound_speed_m_s"}
    return cells if is_cast else []


def _bare(line: str) -> str:
    """Return a line of a header without the marks before it."""
    text = line.lstrip("#%*! ")
    return text[1:].strip() if text.startswith(";") and ";" not in text[1:] else text


def is_data(cells: Sequence[str]) -> bool:
    """Return whether at least two cells are numbers."""
    return sum(bool(NUMBER.fullmatch(cell)) for cell in cells) >= 2


def _columns(lines: list[str]) -> CastTable | None:
    """Read a table whose columns are named above its rows."""
    labels: list[str] = []
    units: list[str] = []
    rows: list[tuple[int, Sequence[str]]] = []
    for k, line in enumerate(lines, 1):
        if not line.strip():
            continue
        if rows:
            if line.lstrip().startswith("["):
                break
            if not line.lstrip().startswith(COMMENT):
                rows.append((k, cells_of(line)))
        elif named := _named_cells(line):
            labels, units = named, []
        elif labels and is_data(cells := cells_of(line)) and len(cells) > 1:
            rows.append((k, cells))
        elif labels and not units:
            found = cells_of(re.sub(r"\[\s+", "[", _bare(line)).removeprefix("Units=").strip("\r\n"))
            units = found if len(found) == len(labels) else []
    bad = MISSING if "CTDPRS" in labels else OFF_SCALE if " EXPORT DATA FILE" in lines[0] else ()
    return CastTable(labels, units, rows, bad=bad) if rows else None


def _pairs(lines: list[str]) -> CastTable | None:
    """Read rows of two numbers below a header of any kind: depth and speed of sound."""
    kept = [(k, line) for k, line in enumerate(lines, 1) if not line.lstrip().startswith(COMMENT)]
    full = [(k, cells) for k, line in kept if (cells := [cell for cell in cells_of(line) if cell])]
    first = next((k for k, (_, cells) in enumerate(full) if len(cells) == 2 and is_data(cells)), None)
    if first is None:
        return None
    speed = float(full[first][1][1].replace(",", "."))
    if not 1300.0 <= speed <= 1900.0:
        return None
    notes = ("its columns are not named, and taken to be depth and speed of sound",)
    return CastTable(("depth", "sound speed"), (), full[first:], notes)


def number(text: str, place: str) -> float:
    """Return the number in a cell, or NaN for an empty one or NaN. Raises ValueError with its place."""
    if NUMBER.fullmatch(text):
        return float(text.replace(",", "."))
    if not text or text.lower() in ("nan", "-nan", "na", "n/a", "null"):
        return math.nan
    raise ValueError(f"{place} = '{text:.30}': must be a number")


def numbers_of(name: str, table: CastTable) -> Columns:
    """Return the columns that a profile has, their lines, and notes. Raises ValueError."""
    used: dict[str, tuple[int, float, float]] = {}
    flags: dict[str, int] = {}
    unused = []
    for at, label in enumerate(table.labels):
        found = quantity_of(label)
        if found is None or found[0] in used:
            unused += [plain] if (plain := label.split(" [")[0].strip()) else []
            continue
        key, unit = found
        try:
            factor, offset = unit_of(key, unit if unit is not None else table.units[at] if table.units else "")
        except ValueError as error:
            raise ValueError(f"{name}: column '{label:.40}': {error}") from None
        used[key] = at, factor, offset
        if f"{label}_FLAG_W" in table.labels:
            flags[key] = table.labels.index(f"{label}_FLAG_W")
    notes, rows = [*table.notes], [*table.rows]
    while rows and not any(map(NUMBER.fullmatch, rows[-1][1])):
        notes.append(f"line {rows[-1][0]} is left out, since it has no number: '{' '.join(rows.pop()[1]):.30}'")
    if unused:
        notes.append(f"columns that are not used: {', '.join(unused)}")
    columns: dict[str, list[float]] = {key: [] for key in used}
    lines = []
    most, least = len(table.labels), max((*(at for at, _, _ in used.values()), *flags.values()), default=0) + 1
    for line, row in rows:
        cells = list(row)
        while len(cells) > most and not cells[-1]:
            cells.pop()
        if not least <= len(cells) <= most:
            raise ValueError(f"{name}:{line}: {len(cells)} values: must be {most}, one for each column")
        lines.append(line)
        for key, (at, factor, offset) in used.items():
            value = number(cells[at], f"{name}:{line}: {table.labels[at].split(' [')[0].strip()}")
            is_bad = value in table.bad or (key in flags and cells[flags[key]] in BAD_FLAGS)
            columns[key].append(math.nan if is_bad else factor * value + offset)
    return Columns({key: np.array(values, np.float64) for key, values in columns.items()}, lines, notes)
