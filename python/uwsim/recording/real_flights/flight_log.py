"""A log of a real flight, from whatever wrote it: each quantity with its source, and notes of what is missing.

Quantities are in the project's axes: the world's x east, y north, z up; the body's x forward, y left, z up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr
from uwsim.scenario.read.note import Note

QUANTITIES: Mapping[str, str] = {
    "attitude": "",
    "position": "m",
    "velocity": "m/s",
    "body velocity": "m/s",
    "rates": "rad/s",
    "depth": "m",
    "place": "deg",
    "altitude": "m",
    "outputs": "us",
    "thrusters": "",
    "efforts": "",
}
"""The quantities of a log, with their units here: the attitude as a quaternion (n, 4) x, y, z, w; velocity in the
world's axes; place as latitude and longitude; altitude as the range from the vehicle's underside to the bed; outputs as
pulse widths, in the order of their numbers; thrusters and efforts as commands in [-1, 1]."""
MOST_BYTES = 1 << 28
MOST_ROWS = 2_000_000
LONGEST_S = 7 * 86400.0
"""Bounds on a file, on the rows of one quantity, which take 0.2 GB, and on a flight's length."""

ENU_FROM_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD = np.array([1.0, -1.0, -1.0])


@dataclass(frozen=True, eq=False, repr=False)
class Series(ShortRepr):
    """A quantity: times_s (n,), increasing, and values (n, k), NaN where absent.

    source: where the log has it, and its unit there. names: of the columns, for thrusters and efforts.
    """

    times_s: Floats
    values: Floats
    source: str
    names: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class FlightLog(ShortRepr):
    """A log. kind: of file. parameters: of the autopilot, as far as logged. events: times [s] and texts.

    assumed: lines about what the reader took for granted, since the log does not state it. unstated: of roll and pitch,
    those that are 0 in the attitude for that reason.
    """

    path: Path
    kind: str
    series: Mapping[str, Series]
    parameters: Mapping[str, float] = field(default_factory=dict)
    events: tuple[tuple[float, str], ...] = ()
    assumed: tuple[str, ...] = ()
    unstated: tuple[str, ...] = ()

    def notes(self) -> list[Note]:
        """Return a note for each quantity that is known or missing, and for each assumption."""
        known = [
            Note("known", f"{name} from {each.source}, {len(each.times_s)} rows{_absent(name, each)}")
            for name, each in self.series.items()
        ]
        moves, speeds = {"outputs", "thrusters", "efforts"}, {"velocity", "body velocity"}
        stated = {*self.series, *moves, *(speeds if speeds & self.series.keys() else ())}
        lacking = [name for name in QUANTITIES if name not in stated]
        if not moves & self.series.keys():
            lacking.append("outputs of thrusters, or their commands")
        return [*known, *(Note("missing", name) for name in lacking), *(Note("assumed", each) for each in self.assumed)]


PARTS = ("east", "north", "up")


def _absent(name: str, series: Series) -> str:
    """Return which part of a series is absent, as text to append; of outputs, most are never used."""
    absent: NDArray[np.bool_] = np.isnan(series.values)
    if name == "outputs":
        absent = np.asarray(absent.all(axis=1)).reshape(-1, 1)
    always = [bool(column.all()) for column in absent.T]
    if name in ("position", "velocity") and any(always):
        return f", without {' and '.join(part for part, lacks in zip(PARTS, always, strict=True) if lacks)}"
    count = int(absent.any(axis=1).sum())
    return f", of which {count} are incomplete" if count else ""


def series_of(path: Path, times_s: Floats, values: Floats, source: str, names: tuple[str, ...] = ()) -> Series | None:
    """Return a series in the order of its times, without repeated times; None for fewer than two rows.

    Raises ValueError for times that no flight has, and for too many rows.
    """
    if len(times_s) > MOST_ROWS:
        raise ValueError(f"{path}: {source}: {len(times_s)} rows: must be at most {MOST_ROWS}: cut the log")
    values = np.where(np.isfinite(values), values, np.nan)
    order = np.argsort(times_s, kind="stable")
    times_s, values = times_s[order], values[order]
    kept = np.isfinite(times_s) & np.concatenate([[True], np.diff(times_s) > 0]) if len(times_s) else np.zeros(0, bool)
    times_s, values = times_s[kept], values[kept]
    if len(times_s) < 2:
        return None
    if (span_s := times_s[-1] - times_s[0]) > LONGEST_S:
        raise ValueError(f"{path}: {source}: lasts {span_s:.6g} s: must be at most {LONGEST_S:g} s")
    return Series(times_s, np.ascontiguousarray(values), source, names)


def attitude_from_ned(roll_pitch_yaw_rad: Floats) -> Floats:
    """Return quaternions (n, 4) in the project's axes from NED's angles (n, 3) [rad]; NaN where an angle is."""
    found = np.full((len(roll_pitch_yaw_rad), 4), np.nan)
    known = np.isfinite(roll_pitch_yaw_rad).all(axis=1)
    if known.any():
        ned_from_frd = Rotation.from_euler("ZYX", roll_pitch_yaw_rad[known][:, ::-1]).as_matrix()
        found[known] = Rotation.from_matrix(ENU_FROM_NED @ ned_from_frd * FRD).as_quat()
    return found


def world_from_ned(ned: Floats) -> Floats:
    """Return vectors (n, 3) in the world's axes."""
    return np.asarray(ned @ ENU_FROM_NED.T, np.float64)


def body_from_frd(frd: Floats) -> Floats:
    """Return vectors (n, 3) in the body's axes."""
    return np.asarray(frd * FRD, np.float64)
