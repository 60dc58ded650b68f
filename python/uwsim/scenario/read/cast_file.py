"""Casts, the measured columns of water that survey and oceanography have: files of sound speed, temperature, salinity.

A file is recognised by its content: CARIS (.svp), Kongsberg (.asvp), Sea-Bird (.cnv, as text), Sippican (.edf), Argo
(NetCDF), the Valeport probes that do not name their columns, and any table whose columns have names: those of AML,
Valeport, Digibar, CastAway, SAIV, Idronaut, ELAC, Sea & Sun, WHP-Exchange, or a CSV. Rows of two numbers without names
are depth and speed of sound. Columns are separated by commas, semicolons, tabs or spaces; decimals may have commas
where these do not separate. Lines without numbers after the last row are a trailer.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.cut_short import warn_if_cut_short
from uwsim.base.texts.text_file import read_limited
from uwsim.scenario.read.argo_cast import read_argo
from uwsim.scenario.read.cast_levels import Cast, Limits, levels_of
from uwsim.scenario.read.cast_quantity import PRESSURE, quantity_of, unit_of
from uwsim.scenario.read.netcdf_file import CLASSIC, SIGNATURE

Floats = NDArray[np.float64]
MOST_BYTES = 1 << 27
NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?")
COMMENT = ("#", "%", "*", "!", "//")
FIELD = re.compile(r"Field\d+\s*:\s*(.+)")
OFF_SCALE = -99.0, -2.53, 35.5
"""Sippican's marks: no value, and the ends of its thermistor's scale, where a torn or grounded wire is."""
MISSING, BAD_FLAGS = (-999.0,), ("3", "4", "5", "9")
"""WHP-Exchange's marks (Swift and Diggs 2008): no value; flags for questionable, bad, not reported, not sampled."""
WIDTH = 11
"""Characters of a column in a .cnv, where columns may touch."""
VALEPORT = {
    "MiniSVP": "pressure,temperature,sound velocity",
    "RapidSVT": "pressure,temperature,sound velocity",
    "RapidSV": "pressure,sound velocity",
    "MiniCTD": "pressure,temperature,conductivity",
}


class _Table(NamedTuple):
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
    data = read_limited(path, name, MOST_BYTES)
    if data.startswith((CLASSIC, SIGNATURE)):
        columns, notes = read_argo(path, name)
        return levels_of(name, columns, [], notes, limits or {})
    lines = _lines(data, name)
    warn_if_cut_short(name, data)
    table = next(filter(None, (reader(name, lines) for reader in READERS)), None)
    if table is None:
        raise ValueError(
            f"{name}: not a cast: no line names its columns, depth or pressure and sound speed or temperature, and its "
            "rows are not two numbers, depth and sound speed: give it a line such as depth_m,sound_speed_m_s above them"
        )
    return levels_of(name, *_numbers(name, table), limits or {})


def _lines(data: bytes, name: str) -> list[str]:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = data.decode("utf-16", "replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
    if "\0" in text:
        raise ValueError(f"{name}: a binary file, expected a cast as text or NetCDF")
    return io.StringIO(text, newline=None).read().split("\n")


def _split(line: str) -> list[str]:
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
    cells = _split(text)
    keys = {found[0] for cell in cells if (found := quantity_of(cell))}
    is_cast = keys & {"depth_m", PRESSURE} and keys & {"temperature_deg_c", "sound_speed_m_s"}
    return cells if is_cast else []


def _bare(line: str) -> str:
    """Return a line of a header without the marks before it."""
    text = line.lstrip("#%*! ")
    return text[1:].strip() if text.startswith(";") and ";" not in text[1:] else text


def _is_data(cells: Sequence[str]) -> bool:
    return sum(bool(NUMBER.fullmatch(cell)) for cell in cells) >= 2


def _sea_bird(name: str, lines: list[str]) -> _Table | None:
    end = next((k for k, line in enumerate(lines) if line.startswith("*END*")), None)
    if end is None or not lines[0].startswith("*"):
        return None
    labels, bad = [], math.nan
    for k, line in enumerate(lines[:end]):
        if found := re.match(r"# name \d+ = ([^:]*):(.*)", line):
            units = re.search(r"\[([^\]]*)\]", found[2])
            labels.append(f"{found[1]} [{units[1] if units else ''}]")
        elif found := re.match(r"# bad_flag = (\S+)", line):
            bad = _number(found[1], f"{name}:{k + 1}: bad_flag")
        elif line.startswith("# file_type = binary"):
            raise ValueError(f"{name}:{k + 1}: a .cnv whose values are binary: must be text (Sea-Bird's ASCII Out)")
    rows: list[tuple[int, Sequence[str]]] = []
    for k, line in enumerate(lines[end + 1 :], end + 2):
        cells = line.split()
        if len(cells) != len(labels):
            cells = [line[at : at + WIDTH].strip() for at in range(0, WIDTH * len(labels), WIDTH)]
        if line.strip() and (rows or _is_data(line.split())):
            rows.append((k, cells))
    is_flagged = bool(labels) and labels[-1].startswith("flag")
    good = [row for row in rows if not (is_flagged and _is_bad(row[1][-1], bad))]
    left = len(rows) - len(good)
    return _Table(labels, (), good, [f"{left} samples that are flagged as bad are left out"] if left else [], (bad,))


def _is_bad(cell: str, bad: float) -> bool:
    return bool(NUMBER.fullmatch(cell)) and float(cell.replace(",", ".")) == bad


def _sections(name: str, lines: list[str]) -> _Table | None:
    """Read CARIS and Kongsberg, whose rows are depth and speed of sound."""
    is_caris = lines[0].upper().startswith("[SVP_VERSION_")
    if not is_caris and not re.match(r"\(\s*SoundVelocity", lines[0], re.IGNORECASE):
        return None
    head = re.compile(r"Section\b" if is_caris else r"\(")
    starts = [k for k, line in enumerate(lines) if head.match(line.strip())]
    if not starts:
        raise ValueError(f"{name}: has no line 'Section ...', below which the values are")
    stop = starts[1] if len(starts) > 1 else len(lines)
    rows = [(k + 1, lines[k].split()) for k in range(starts[0] + 1, stop) if lines[k].strip()]
    notes = [f"the first of its {len(starts)} casts is used"] if len(starts) > 1 else []
    stated = re.search(r"(\d+)\s*\)\s*$", lines[0])
    if not is_caris and stated and int(stated[1]) != len(rows):
        notes.append(f"its first line states {int(stated[1])} levels, but it has {len(rows)}")
    return _Table(("depth", "sound speed"), (), rows, notes)


def _valeport(name: str, lines: list[str]) -> _Table | None:
    """Read the text of Valeport's probes that do not name their columns."""
    head = "\n".join(lines[:40])
    kind = re.search(rf"^({'|'.join(VALEPORT)}): ", head, re.MULTILINE)
    unit = re.search(r"^Pressure units: (\S+)", head, re.MULTILINE)
    if not kind or not unit:
        return None
    labels = VALEPORT[kind[1]].split(",")
    labels[0] = "depth" if unit[1] == "m" else f"pressure [{unit[1]}]"
    begin = head.count("\n", 0, unit.start()) + 1
    return _Table(labels, (), [(k + 1, _split(lines[k])) for k in range(begin, len(lines)) if lines[k].strip()])


def _fields(name: str, lines: list[str]) -> _Table | None:
    """Read Sippican's raw .edf, which names its columns one a line."""
    found = [(k, named[1].strip()) for k, line in enumerate(lines) if (named := FIELD.match(line))]
    if not found:
        return None
    begin = found[-1][0] + 1
    rows = [(k, _split(line)) for k, line in enumerate(lines[begin:], begin + 1)]
    rows = [row for row in rows if row[1] and not row[1][0].startswith(COMMENT)]
    return _Table([label for _, label in found], (), rows, bad=OFF_SCALE)


def _columns(name: str, lines: list[str]) -> _Table | None:
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
                rows.append((k, _split(line)))
        elif named := _named_cells(line):
            labels, units = named, []
        elif labels and _is_data(cells := _split(line)) and len(cells) > 1:
            rows.append((k, cells))
        elif labels and not units:
            found = _split(re.sub(r"\[\s+", "[", _bare(line)).removeprefix("Units=").strip("\r\n"))
            units = found if len(found) == len(labels) else []
    bad = MISSING if "CTDPRS" in labels else OFF_SCALE if " EXPORT DATA FILE" in lines[0] else ()
    return _Table(labels, units, rows, bad=bad) if rows else None


def _pairs(name: str, lines: list[str]) -> _Table | None:
    """Read rows of two numbers below a header of any kind: depth and speed of sound."""
    kept = [(k, line) for k, line in enumerate(lines, 1) if not line.lstrip().startswith(COMMENT)]
    full = [(k, cells) for k, line in kept if (cells := [cell for cell in _split(line) if cell])]
    first = next((k for k, (_, cells) in enumerate(full) if len(cells) == 2 and _is_data(cells)), None)
    if first is None:
        return None
    speed = float(full[first][1][1].replace(",", "."))
    if not 1300.0 <= speed <= 1900.0:
        return None
    notes = ("its columns are not named, and taken to be depth and speed of sound",)
    return _Table(("depth", "sound speed"), (), full[first:], notes)


READERS: tuple[Callable[[str, list[str]], _Table | None], ...] = (
    _sea_bird, _sections, _valeport, _fields, _columns, _pairs,
)  # fmt: skip
"""Each returns a table, or None for a file of another kind."""


def _number(text: str, place: str) -> float:
    """Return the number in a cell, or NaN for an empty one or NaN. Raises ValueError with its place."""
    if NUMBER.fullmatch(text):
        return float(text.replace(",", "."))
    if not text or text.lower() in ("nan", "-nan", "na", "n/a", "null"):
        return math.nan
    raise ValueError(f"{place} = '{text:.30}': must be a number")


def _numbers(name: str, table: _Table) -> tuple[dict[str, Floats], list[int], list[str]]:
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
            value = _number(cells[at], f"{name}:{line}: {table.labels[at].split(' [')[0].strip()}")
            is_bad = value in table.bad or (key in flags and cells[flags[key]] in BAD_FLAGS)
            columns[key].append(math.nan if is_bad else factor * value + offset)
    return {key: np.array(values, np.float64) for key, values in columns.items()}, lines, notes
