"""Opens map files, reads points from map or cloud files, and compares maps' grids."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.cloud_files import read_cloud
from uwsim.mapping.files.formats import MAP_FORMATS, Origin, cloud_format
from uwsim.mapping.occupancy_map import OccupancyMap

FIRST_LINES = {b"# Octomap OcTree binary file": ".bt", b"# Octomap OcTree file": ".ot"}


def open_map(path: Path, origin_world_m: Origin = None) -> OccupancyMap:
    """Read a map. Raises OSError if the file cannot be read, ValueError if it is not a valid map."""
    suffix = path.suffix if path.suffix in MAP_FORMATS else ".bt"  # whose reader accepts any name
    return MAP_FORMATS[suffix].read(path, origin_world_m)


def map_format(path: Path) -> str:
    """Return the key in MAP_FORMATS of a valid map file: OctoMap's by the first line, another by the suffix."""
    with path.open("rb") as file:
        return FIRST_LINES.get(file.readline(64).strip(), path.suffix if path.suffix in MAP_FORMATS else ".bt")


def open_points(path: Path, origin_world_m: Origin = None) -> tuple[NDArray[np.float64], float | None]:
    """Return the occupied voxel centres (n, 3) and resolution of a map file, or the points of a cloud file and None."""
    if path.suffix not in MAP_FORMATS and cloud_format(path) is not None:
        return read_cloud(path), None
    occupancy = open_map(path, origin_world_m)
    return occupancy.occupied_voxels(), occupancy.resolution_m


def require_same_grid(first: OccupancyMap, second: OccupancyMap) -> None:
    """Raise ValueError unless two maps have the same resolution and origin."""
    if first.resolution_m != second.resolution_m:
        raise ValueError(
            f"resolution_m = {first.resolution_m:g} and {second.resolution_m:g} m: must be the same in both maps"
        )
    if not np.array_equal(first.origin_world_m, second.origin_world_m):
        raise ValueError("origin_world_m: must be the same in both maps")
