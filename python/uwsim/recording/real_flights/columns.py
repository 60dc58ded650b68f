"""Tables (CSV) by a stated mapping: which column is which quantity, in which unit.

A mapping is text such as `t = time [ms], yaw = heading [deg], m1 = servo1 [us]`, or a YAML file with one such line for
each column: `t: time [ms]`.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.named import did_you_mean
from uwsim.base.texts.csv_table import CsvTable, read_csv
from uwsim.recording.real_flights.flight_log import QUANTITIES, FlightLog, Series, attitude_from_ned, series_of
from uwsim.recording.real_flights.motion import TILT
from uwsim.scenario.read.spec_file import read_yaml

KIND = "a table (CSV)"
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}
ANGLES = {"rad": 1.0, "deg": np.pi / 180}
SPEEDS = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "kn": 1852 / 3600}
SHARES = {"": 1.0}
RATES = {"rad/s": 1.0, "deg/s": np.pi / 180}
UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    **dict.fromkeys(("east", "north", "up", "down", "depth"), LENGTHS),
    **dict.fromkeys(("roll", "pitch", "heading", "yaw"), ANGLES),
    **dict.fromkeys(("qx", "qy", "qz", "qw"), SHARES),
    **dict.fromkeys(("velocity east", "velocity north", "velocity up", "velocity down", *AXES[:3]), SPEEDS),
    **dict.fromkeys(("roll rate", "pitch rate", "yaw rate"), RATES),
}
"""The units of each quantity that a column may be.

Roll is positive to starboard, pitch with the bow up; heading is clockwise from north, yaw counter-clockwise from east.
The quaternion turns the body (x forward, y left, z up) to east, north, up; surge, sway, heave and the rates are in that
body's axes. Also `servoN [us]`, `thruster NAME` and `effort AXIS`, commands in [-1, 1].
"""
ENTRY = re.compile(r"\s*(?P<what>[A-Za-z][\w ]*?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*")
SERVO, THRUSTER, EFFORT = re.compile(r"servo([1-9]\d?)"), re.compile(r"thruster (\S+)"), re.compile(r"effort (\S+)")
SERVOS = 32


class Columns:
    """A mapping: by quantity, the column and the factor to the unit that it has here."""

    def __init__(self, entries: Mapping[str, str], name: str) -> None:
        """entries: quantity and unit by column. name: of the mapping, for messages. Raises ValueError."""
        self.found: dict[str, tuple[str, float, str]] = {}
        for column, text in entries.items():
            match = ENTRY.fullmatch(str(text))
            what, unit = (match["what"], match["unit"] or "") if match else (str(text), "")
            units = _units(what)
            if units is None:
                known = (*UNITS, "servo1", "thruster NAME", *(f"effort {axis}" for axis in AXES))
                raise ValueError(
                    f"{name}: {column} = '{what}': must be one of {', '.join(known)}{did_you_mean(what, known)}"
                )
            if unit not in units:
                rule = f"must be in {' or '.join(f'[{each}]' for each in units)}" if any(units) else "has no unit"
                raise ValueError(f"{name}: {column} = '{what} [{unit}]': {rule}")
            if what in self.found:
                raise ValueError(f"{name}: {what}: is both '{self.found[what][0]}' and '{column}'")
            self.found[what] = column, units[unit], unit
        if "time" not in self.found:
            raise ValueError(f"{name}: must name the column of the time, such as `t = time [s]`")

    @classmethod
    def of(cls, given: str) -> Columns:
        """Return the mapping of a text, or of a YAML file. Raises ValueError with the entry and the rule."""
        if "=" not in given:
            document = read_yaml(Path(given), given)
            return cls({str(key): str(value) for key, value in dict(document.values).items()}, given)
        pairs = [part.partition("=") for part in given.split(",")]
        columns = [column.strip() for column, _, _ in pairs]
        if twice := [column for column, count in Counter(columns).items() if count > 1]:
            raise ValueError(f"--columns: column '{twice[0]}': is given twice")
        return cls({column.strip(): what for column, _, what in pairs}, "--columns")


def _units(what: str) -> Mapping[str, float] | None:
    if (servo := SERVO.fullmatch(what)) and int(servo[1]) <= SERVOS:
        return {"us": 1.0}
    if THRUSTER.fullmatch(what) or ((axis := EFFORT.fullmatch(what)) and axis[1] in AXES):
        return {"": 1.0}
    return UNITS.get(what)


def read_columns(path: Path, columns: Columns | None) -> FlightLog:
    """Read a table. Raises OSError, or ValueError with line and column."""
    if columns is None:
        raise ValueError(f"{path}: {KIND}: must be read by `--columns`, such as `t = time [s], yaw = heading [deg]`")
    table = read_csv(path)
    return _Table(path, table, columns).log()


class _Table:
    """A table being read."""

    def __init__(self, path: Path, table: CsvTable, columns: Columns) -> None:
        self._path, self._columns = path, columns
        self._values = {
            what: table.numbers(column, may_lack=what != "time") * factor
            for what, (column, factor, _) in columns.found.items()
        }
        times_s = self._values["time"]
        if (back := np.flatnonzero(np.diff(times_s) <= 0)).size:
            at = int(back[0]) + 1
            raise ValueError(f"{path}:{table.line(at)}: time = {times_s[at]:.12g} s: must increase")

    def log(self) -> FlightLog:
        """Return the log. Raises ValueError."""
        v, found = self._values, dict[str, Series]()
        angles = np.column_stack([self._or_nan("roll"), self._or_nan("pitch"), self._heading()])
        quaternion = ("qx", "qy", "qz", "qw")
        is_turned = all(each in v for each in quaternion)
        has_heading = not is_turned and bool(np.isfinite(angles[:, 2]).any())
        unstated = tuple(name for name in TILT if has_heading and name not in v)
        angles[:, [TILT.index(name) for name in unstated]] = 0.0
        attitude = np.column_stack([v[each] for each in quaternion]) if is_turned else attitude_from_ned(angles)
        up = self._signed("up", "down")
        self._add(found, "attitude", attitude, (*quaternion, "roll", "pitch", "heading", "yaw"))
        self._add(
            found,
            "position",
            np.column_stack([self._or_nan("east"), self._or_nan("north"), up]),
            ("east", "north", "up", "down"),
        )
        self._add(found, "depth", self._or_nan("depth")[:, None], ("depth",))
        velocity = ("velocity east", "velocity north", "velocity up", "velocity down")
        rise = self._signed("velocity up", "velocity down")
        self._add(
            found, "velocity", np.column_stack([self._or_nan(velocity[0]), self._or_nan(velocity[1]), rise]), velocity
        )
        self._add(found, "body velocity", np.column_stack([self._or_nan(each) for each in AXES[:3]]), AXES[:3])
        rates = ("roll rate", "pitch rate", "yaw rate")
        self._add(found, "rates", np.column_stack([self._or_nan(each) for each in rates]), rates)
        servos = {int(match[1]): what for what in v if (match := SERVO.fullmatch(what))}
        if servos:
            width = range(1, max(servos) + 1)
            pulses = np.column_stack([self._or_nan(f"servo{k}") for k in width])
            self._add(found, "outputs", pulses, tuple(servos.values()))
        for quantity, pattern in (("thrusters", THRUSTER), ("efforts", EFFORT)):
            names = {match[1]: what for what in v if (match := pattern.fullmatch(what))}
            if names:
                commands = np.column_stack([v[what] for what in names.values()])
                self._add(found, quantity, commands, tuple(names.values()), tuple(names))
        known = {name: found[name] for name in QUANTITIES if name in found}
        assumed = tuple(f"{name} is 0: no column states it, and no model is compared with it" for name in unstated)
        return FlightLog(self._path, KIND, known, assumed=assumed, unstated=unstated)

    def _or_nan(self, what: str) -> Floats:
        return self._values.get(what, np.full(len(self._values["time"]), np.nan))

    def _signed(self, up: str, down: str) -> Floats:
        return self._values[up] if up in self._values else -self._or_nan(down)

    def _heading(self) -> Floats:
        return self._values["heading"] if "heading" in self._values else 0.5 * np.pi - self._or_nan("yaw")

    def _add(
        self, found: dict[str, Series], quantity: str, values: Floats, of: tuple[str, ...], names: tuple[str, ...] = ()
    ) -> None:
        if not np.isfinite(values).any():
            return
        columns = self._columns.found
        parts = [f"{columns[what][0]} [{columns[what][2]}]" for what in of if what in columns]
        series = series_of(self._path, self._values["time"], values, ", ".join(parts).replace(" []", ""), names)
        if series is not None:
            found[quantity] = series
