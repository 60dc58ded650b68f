"""OctoMap's files, which the core reads and writes; either is recognized by its first line.

A map whose origin is not the world's has it in a comment below that line, which OctoMap's own programs skip.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.base.atomic_file import GrowingFile
from uwsim.base.own_files import mark
from uwsim.mapping.files.formats import MapFileFormat
from uwsim.mapping.occupancy_map import MapFormat, OccupancyMap, origin_line

CHUNK_BYTES = 1 << 24


def _writer(map_format: MapFormat) -> Callable[[OccupancyMap, Path], None]:
    def write(occupancy: OccupancyMap, path: Path) -> None:
        line = origin_line(occupancy.origin_world_m)
        if not line:
            occupancy._map.write(str(path), map_format)  # atomically, and without all bytes in memory
            mark(path.resolve())
            return
        file = GrowingFile(path)
        try:
            with TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
                whole = Path(folder, path.name)
                occupancy._map.write(str(whole), map_format)
                with whole.open("rb") as content:
                    file.write(content.readline() + line)
                    while part := content.read(CHUNK_BYTES):
                        file.write(part)
            file.close()
        finally:
            file.discard()

    return write


BT = MapFileFormat("occupied or free", OccupancyMap.read, _writer("bt"))
OT = MapFileFormat("with all probabilities", OccupancyMap.read, _writer("ot"), has_probabilities=True)
