"""Poses along a track flown by a survey, a mission or a program of your own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.base.npz import read_npz
from uwsim.base.texts.csv_table import CsvTable, read_csv
from uwsim.base.texts.text_file import require_regular

POSITIONS, ORIENTATIONS, TIMES, PATH = "position_world_m", "orientation_xyzw", "time_s", "path_world_m"
ANGLES = ("yaw_rad", "pitch_rad", "roll_rad")


@dataclass(frozen=True, eq=False)
class Track:
    """A vehicle's poses over time: times_s (n,), never decreasing, positions_m (n, 3), orientations_xyzw (n, 4)."""

    times_s: Floats
    positions_m: Floats
    orientations_xyzw: Floats

    def spread(self, count: int) -> Track:
        """Return `count` evenly spaced poses on the track. Raises ValueError if the track has fewer."""
        if count > len(self.times_s):
            raise ValueError(f"n = {count:,}: the track has {len(self.times_s):,} poses")
        chosen = np.linspace(0, len(self.times_s) - 1, count).round().astype(int)
        return Track(self.times_s[chosen], self.positions_m[chosen], self.orientations_xyzw[chosen])


def read_track(path: str | Path) -> Track:
    """Read a track: track-VEHICLE.csv from `uwsim run`, track.npz from `uwsim survey`, or an .npz of your own.

    Your own file needs position_world_m (n, 3), orientation_xyzw (n, 4) and optionally time_s (n,). A survey track
    contains only the path of the sonar: the vehicle is assumed to be at these positions, level and heading along the
    path. Without times, poses are one second apart. Raises ValueError or OSError.
    """
    file = Path(path)
    if file.suffix == ".csv":
        return _from_csv(read_csv(file))
    try:
        data = require_regular(file).read_bytes()
    except OSError as error:
        raise OSError(f"'{path}': cannot be read: {error.strerror or error}") from None
    try:
        return _from_npz(data)
    except ValueError as error:
        raise ValueError(f"track '{path}': {error}") from None


def track_of(samples: Any) -> Track:
    """Build a track from the samples of a flight (flight.samples.Samples), or from columns with the same names."""
    turns = Rotation.from_euler("ZYX", np.column_stack([samples[name] for name in ANGLES]))
    positions = np.column_stack([samples[name] for name in ("x_m", "y_m", "z_m")])
    return _checked(samples[TIMES], positions, turns.as_quat())


def _from_csv(table: CsvTable) -> Track:
    needed = (TIMES, "x_m", "y_m", "z_m", *ANGLES)
    missing = [name for name in needed if name not in table.columns]
    if missing:
        raise ValueError(f"{table.name}: has no column {missing[0]}: `uwsim run` writes such files, track-VEHICLE.csv")
    columns = {name: table.numbers(name) for name in needed}
    try:
        return track_of(columns)
    except ValueError as error:
        raise ValueError(f"{table.name}: {error}") from None


def _from_npz(data: bytes) -> Track:
    fields = read_npz(data)
    if PATH in fields:
        positions = fields[PATH]
        return _checked(_a_second_each(positions), positions, _headings_xyzw(positions))
    for name in (POSITIONS, ORIENTATIONS):
        if name not in fields:
            raise ValueError(f"has no array {name}")
    times = fields.get(TIMES, _a_second_each(fields[POSITIONS]))
    return _checked(times, fields[POSITIONS], fields[ORIENTATIONS])


def _a_second_each(positions: NDArray[Any]) -> Floats:
    return np.arange(float(np.atleast_1d(positions).shape[0]))


def _headings_xyzw(positions: NDArray[Any]) -> Floats:
    """Return level orientations along the path, (n, 4)."""
    if positions.dtype.kind not in "iuf":
        raise ValueError(f"{PATH}: must hold real numbers")
    if positions.ndim != 2 or positions.shape[1:] != (3,) or len(positions) < 2:
        raise ValueError(f"{PATH}: shape {positions.shape}: must be (n, 3), of two positions or more")
    along = np.gradient(positions, axis=0)
    return np.asarray(Rotation.from_euler("z", np.arctan2(along[:, 1:2], along[:, :1])).as_quat(), np.float64)


def _checked(times: Any, positions: Any, orientations: Any) -> Track:
    arrays = {TIMES: (times, ()), POSITIONS: (positions, (3,)), ORIENTATIONS: (orientations, (4,))}
    count, found = np.atleast_1d(positions).shape[0], []
    for name, (values, width) in arrays.items():
        if np.asarray(values).dtype.kind not in "iuf":
            raise ValueError(f"{name}: must hold real numbers")
        array = np.asarray(values, np.float64)
        if array.shape != (count, *width):
            raise ValueError(f"{name}: shape {array.shape}: must be {(count, *width)}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name}: must be finite")
        found.append(array)
    if count == 0:
        raise ValueError("has no poses")
    if (np.diff(found[0]) < 0.0).any() or found[0][0] < 0.0:
        raise ValueError(f"{TIMES}: must begin at 0 or later, and not decrease")
    lengths = np.linalg.norm(found[2], axis=1)
    if (np.abs(lengths - 1.0) > 1e-3).any():
        raise ValueError(f"{ORIENTATIONS}: must be unit quaternions, x, y, z, w")
    return Track(found[0], found[1], found[2] / lengths[:, None])
