"""A survey track, stored next to the map in track.npz: the sonar's path and the area to be covered."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.npz import npz_bytes, read_npz
from uwsim.base.texts.text_file import require_regular

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRACK = "track.npz"
"""Name of the file, next to map.bt."""
VERSION = 1
FIELDS = ("version", "path_world_m", "area_world_m", "range_max_m", "scenario_name")


@dataclass(frozen=True, eq=False)
class SurveyTrack:
    """Everything about a survey that affects the score of its map.

    path_world_m: (n, 3), the sonar's position at each ping, in order. area_world_m: (k, 2), the polygon to survey.
    range_max_m: the sonar's maximum range. scenario_name: empty if unknown.
    """

    path_world_m: NDArray[np.float64]
    area_world_m: NDArray[np.float64]
    range_max_m: float
    scenario_name: str = ""

    def __repr__(self) -> str:
        length_m = float(np.linalg.norm(np.diff(self.path_world_m, axis=0), axis=1).sum())
        of = f" of '{self.scenario_name}'" if self.scenario_name else ""
        return f"<SurveyTrack{of}: {len(self.path_world_m)} pings on {length_m:.0f} m>"

    def plot(self) -> Figure:
        """Return a figure of the path seen from above, coloured by height, over the area."""
        from uwsim.scoring.track_plot import plot  # matplotlib takes a second to import

        return plot(self.path_world_m, self.area_world_m, repr(self))

    def _repr_png_(self) -> bytes:
        from uwsim.scoring.track_plot import png

        return png(self.plot())

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a NumPy archive atomically; the same track always produces the same bytes. Raises OSError."""
        content = npz_bytes(
            version=np.int64(VERSION),
            path_world_m=np.asarray(self.path_world_m, np.float64),
            area_world_m=np.asarray(self.area_world_m, np.float64),
            range_max_m=np.float64(self.range_max_m),
            scenario_name=np.str_(self.scenario_name),
        )
        write_atomically(Path(path), content)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Self:
        """Read a track from a file.

        Raises OSError if the file cannot be read, ValueError if it is not a valid track.
        """
        try:
            data = require_regular(Path(path)).read_bytes()
        except OSError as error:
            raise OSError(f"'{path}': cannot be read: {error.strerror or error}") from None
        try:
            return cls._checked(_fields(data))
        except ValueError as error:
            raise ValueError(f"'{path}': not a valid track of a survey: {error}") from None

    @classmethod
    def _checked(cls, fields: dict[str, NDArray[Any]]) -> Self:
        version = fields["version"]
        if version.dtype != np.int64 or version.shape != () or int(version) != VERSION:
            raise ValueError(f"version = {version}: must be {VERSION}")
        path, area = fields["path_world_m"], fields["area_world_m"]
        for name, array, columns, least in (("path_world_m", path, 3, 0), ("area_world_m", area, 2, 3)):
            if array.dtype != np.float64 or array.ndim != 2 or array.shape[1] != columns or len(array) < least:
                raise ValueError(f"{name}: {array.dtype} {array.shape}, expected float64 (n, {columns})")
            if not np.isfinite(array).all():
                raise ValueError(f"{name}: must be finite")
        range_max_m = fields["range_max_m"]
        if range_max_m.dtype != np.float64 or range_max_m.shape != () or not 0.0 < float(range_max_m) < np.inf:
            raise ValueError(f"range_max_m = {range_max_m} m: must be positive")
        return cls(path, area, float(range_max_m), str(fields["scenario_name"]))


def _fields(data: bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of a track file without validating them. Raises ValueError with a specific message."""
    try:
        fields = read_npz(data)
    except ValueError:
        raise ValueError("it is damaged, or another kind of file; `uwsim survey` writes it") from None
    for name in FIELDS:
        if name not in fields:
            raise ValueError(f"it has no '{name}': it is damaged, or from another program")
    return fields
