"""OctoMap's files, which the core reads and writes; either is recognized by its first line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from uwsim.base.own_files import mark
from uwsim.mapping.files.formats import MapFileFormat
from uwsim.mapping.occupancy_map import MapFormat, OccupancyMap


def _writer(map_format: MapFormat) -> Callable[[OccupancyMap, Path], None]:
    def write(occupancy: OccupancyMap, path: Path) -> None:
        occupancy._map.write(str(path), map_format)  # atomically, and without all bytes in memory
        mark(path.resolve())

    return write


BT = MapFileFormat("occupied or free", OccupancyMap.read, _writer("bt"))
OT = MapFileFormat("with all probabilities", OccupancyMap.read, _writer("ot"), has_probabilities=True)
