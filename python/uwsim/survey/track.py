"""What a map's score needs of the survey that made it, in a file beside the map: where the sonar was, and what for."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from uwsim.atomic_file import write_atomically
from uwsim.survey.record import SurveyRecord

TRACK = "track.npz"
"""Its name beside map.bt."""
VERSION = 1


@dataclass(frozen=True, eq=False)
class Track:
    """path_world_m: (n, 3), the sonar's position at each ping, in order. area_world_m: (k, 2), the polygon to survey.

    range_max_m: how far the sonar saw. scenario_name: of the place; empty when it is not known.
    """

    path_world_m: NDArray[np.float64]
    area_world_m: NDArray[np.float64]
    range_max_m: float
    scenario_name: str = ""

    @classmethod
    def of(cls, record: SurveyRecord) -> Self:
        """Take it from a survey's record."""
        return cls(record.path_world_m, record.area_world_m, record.range_max_m, record.scenario_name)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a NumPy archive, atomically; the same track gives the same bytes. Raises OSError."""
        file = io.BytesIO()
        np.savez_compressed(
            file,
            version=np.int64(VERSION),
            path_world_m=np.asarray(self.path_world_m, np.float64),
            area_world_m=np.asarray(self.area_world_m, np.float64),
            range_max_m=np.float64(self.range_max_m),
            scenario_name=np.str_(self.scenario_name),
        )
        write_atomically(Path(path), file.getvalue())

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Self:
        """Raises OSError when it cannot be read, ValueError when it is no sound track."""
        try:
            data = Path(path).read_bytes()
        except OSError as error:
            raise OSError(f"'{path}': cannot be read: {error.strerror or error}") from None
        try:
            return cls._of_bytes(data)
        except Exception as error:  # a hostile archive makes NumPy and zipfile raise all sorts
            reason = " ".join(str(error).split()) or type(error).__name__
            raise ValueError(f"'{path}': not a sound track of a survey: {reason}") from None

    @classmethod
    def _of_bytes(cls, data: bytes) -> Self:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            if int(file["version"]) != VERSION:
                raise ValueError(f"version = {int(file['version'])}: must be {VERSION}")
            path, area, reach = file["path_world_m"], file["area_world_m"], float(file["range_max_m"])
            scenario_name = str(file["scenario_name"])
        for name, array, columns, least in (("path_world_m", path, 3, 0), ("area_world_m", area, 2, 3)):
            if array.dtype != np.float64 or array.ndim != 2 or array.shape[1] != columns or len(array) < least:
                raise ValueError(f"{name}: {array.dtype} {array.shape}, expected float64 (n, {columns})")
            if not np.isfinite(array).all():
                raise ValueError(f"{name}: must be finite")
        if not 0.0 < reach < np.inf:
            raise ValueError(f"range_max_m = {reach} m: must be positive")
        return cls(path, area, reach, scenario_name)
