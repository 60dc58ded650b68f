"""Casts that are known by their content, in the group `uwsim.kinds.cast` of entry points."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.reader import Reader
from uwsim.base.texts.text_file import read_limited
from uwsim.scenario.read.cast_file import (
    COMMENT,
    MOST_BYTES,
    NUMBER,
    OFF_SCALE,
    CastTable,
    cast_lines,
    cells_of,
    is_data,
    lines_of,
    number,
    numbers_of,
)  # fmt: skip
from uwsim.scenario.read.cast_levels import LATITUDE_DEG, PRESSURE, Columns, depth_at_m
from uwsim.scenario.read.netcdf_file import CLASSIC, SIGNATURE, read_netcdf

FIELD = re.compile(r"Field\d+\s*:\s*(.+)")
WIDTH = 11
"""Characters of a column in a .cnv, where columns may touch."""
VALEPORT = {
    "MiniSVP": "pressure,temperature,sound velocity",
    "RapidSVT": "pressure,temperature,sound velocity",
    "RapidSV": "pressure,sound velocity",
    "MiniCTD": "pressure,temperature,conductivity",
}
CARIS, KONGSBERG = re.compile(r"\[SVP_VERSION_", re.IGNORECASE), re.compile(r"\(\s*SoundVelocity", re.IGNORECASE)
BAD_QC = (b"3", b"4", b"9")
"""Argo's flags (Argo user's manual, table 2): probably bad, bad, missing."""


def _is_sea_bird(path: Path, head: bytes) -> bool:
    return lines_of(head)[0].startswith("*") and any(
        line.startswith("*END*") for line in lines_of(read_limited(path, str(path), MOST_BYTES))
    )


def _sea_bird(name: str, lines: list[str]) -> CastTable:
    end = next(k for k, line in enumerate(lines) if line.startswith("*END*"))
    labels, bad = [], math.nan
    for k, line in enumerate(lines[:end]):
        if found := re.match(r"# name \d+ = ([^:]*):(.*)", line):
            units = re.search(r"\[([^\]]*)\]", found[2])
            labels.append(f"{found[1]} [{units[1] if units else ''}]")
        elif found := re.match(r"# bad_flag = (\S+)", line):
            bad = number(found[1], f"{name}:{k + 1}: bad_flag")
        elif line.startswith("# file_type = binary"):
            raise ValueError(f"{name}:{k + 1}: a .cnv whose values are binary: must be text (Sea-Bird's ASCII Out)")
    rows: list[tuple[int, Sequence[str]]] = []
    for k, line in enumerate(lines[end + 1 :], end + 2):
        cells = line.split()
        if len(cells) != len(labels):
            cells = [line[at : at + WIDTH].strip() for at in range(0, WIDTH * len(labels), WIDTH)]
        if line.strip() and (rows or is_data(line.split())):
            rows.append((k, cells))
    is_flagged = bool(labels) and labels[-1].startswith("flag")
    good = [row for row in rows if not (is_flagged and _is_bad(row[1][-1], bad))]
    left = len(rows) - len(good)
    return CastTable(labels, (), good, [f"{left} samples that are flagged as bad are left out"] if left else [], (bad,))


def _is_bad(cell: str, bad: float) -> bool:
    return bool(NUMBER.fullmatch(cell)) and float(cell.replace(",", ".")) == bad


def _sections(name: str, lines: list[str]) -> CastTable:
    """Read CARIS and Kongsberg, whose rows are depth and speed of sound."""
    is_caris = CARIS.match(lines[0])
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
    return CastTable(("depth", "sound speed"), (), rows, notes)


def _valeport_head(lines: list[str]) -> list[re.Match[str]]:
    """Return the lines that name the kind of probe and its unit of pressure, as far as they are there."""
    head = "\n".join(lines[:40])
    patterns = rf"^({'|'.join(VALEPORT)}): ", r"^Pressure units: (\S+)"
    return [found for pattern in patterns if (found := re.search(pattern, head, re.MULTILINE))]


def _valeport(name: str, lines: list[str]) -> CastTable:
    """Read the text of Valeport's probes that do not name their columns."""
    kind, unit = _valeport_head(lines)
    labels = VALEPORT[kind[1]].split(",")
    labels[0] = "depth" if unit[1] == "m" else f"pressure [{unit[1]}]"
    begin = unit.string.count("\n", 0, unit.start()) + 1
    return CastTable(labels, (), [(k + 1, cells_of(lines[k])) for k in range(begin, len(lines)) if lines[k].strip()])


def _fields(name: str, lines: list[str]) -> CastTable:
    """Read Sippican's raw .edf, which names its columns one a line."""
    found = [(k, named[1].strip()) for k, line in enumerate(lines) if (named := FIELD.match(line))]
    begin = found[-1][0] + 1
    rows = [(k, cells_of(line)) for k, line in enumerate(lines[begin:], begin + 1)]
    rows = [row for row in rows if row[1] and not row[1][0].startswith(COMMENT)]
    return CastTable([label for _, label in found], (), rows, bad=OFF_SCALE)


def read_argo(path: Path, name: str) -> Columns:
    """Read the first profile of an Argo float: adjusted values where it has them, without those flagged as bad."""
    names = {"PRES": PRESSURE, "TEMP": "temperature_deg_c", "PSAL": "salinity_psu"}
    wanted = {f"{key}{end}" for key in names for end in ("", "_QC", "_ADJUSTED", "_ADJUSTED_QC")}
    try:
        held = read_netcdf(path, f"cast '{name}'", wanted | {"DATA_MODE", "LATITUDE"})
    except ImportError:
        raise
    except Exception as error:  # damaged files raise anything in both readers
        raise ValueError(f"{name}: not a readable NetCDF: {' '.join(str(error).split())}") from None
    if not {"PRES", "TEMP"} <= held.keys():
        raise ValueError(f"{name}: not an Argo profile: must have the variables PRES and TEMP")
    mode = bytes(np.ravel(held["DATA_MODE"].values)[:1].tobytes()) if "DATA_MODE" in held else b"R"
    columns, notes = {}, []
    for short, key in names.items():
        used = f"{short}_ADJUSTED" if mode in (b"A", b"D") and f"{short}_ADJUSTED" in held else short
        if used not in held:
            continue
        values = np.atleast_2d(np.array(held[used].values))
        if values.ndim != 2 or values.dtype.kind not in "iuf" or not values.size:
            raise ValueError(f"{name}: {used} has the shape {held[used].values.shape}: must be profiles by levels")
        found = values[0].astype(np.float64)
        found[found == held[used].attributes.get("_FillValue", 99999.0)] = math.nan
        if (flags := held.get(f"{used}_QC")) is not None and np.size(flags.values) == values.size:
            flag = np.reshape(np.array(flags.values, "S1"), values.shape)[0]
            found[np.isin(flag, BAD_QC)] = math.nan
        columns[key] = found
        if short == "PRES" and len(values) > 1:
            notes.append(f"the first of its {len(values)} profiles is used")
    if len({len(each) for each in columns.values()}) > 1:
        raise ValueError(f"{name}: PRES, TEMP and PSAL must have the same number of levels")
    latitude = held["LATITUDE"].values if "LATITUDE" in held else np.array([LATITUDE_DEG])
    columns["depth_m"] = depth_at_m(columns.pop(PRESSURE), _latitude(latitude))
    if mode not in (b"A", b"D"):
        notes.append("values are those in real time, not adjusted")
    return Columns(columns, [], notes)


def _latitude(values: Any) -> float:
    first = float(np.ravel(values)[0]) if np.size(values) and np.asarray(values).dtype.kind in "iuf" else math.nan
    return first if abs(first) <= 90.0 else LATITUDE_DEG


def _text(read: Callable[[str, list[str]], CastTable]) -> Callable[[Path, str], Columns]:
    return lambda path, name: numbers_of(name, read(name, cast_lines(path, name)))


ARGO = Reader("an Argo float's profile (NetCDF)", lambda path, head: head.startswith((CLASSIC, SIGNATURE)), read_argo)
SEA_BIRD = Reader("Sea-Bird's .cnv", _is_sea_bird, _text(_sea_bird))
SECTIONS = Reader(
    "CARIS's .svp or Kongsberg's .asvp",
    lambda path, head: any(each.match(lines_of(head)[0]) for each in (CARIS, KONGSBERG)),
    _text(_sections),
)
VALEPORT_TEXT = Reader(
    "the text of Valeport's probes", lambda path, head: len(_valeport_head(lines_of(head))) == 2, _text(_valeport)
)
SIPPICAN = Reader("Sippican's .edf", lambda path, head: any(map(FIELD.match, lines_of(head))), _text(_fields))
