"""Opens map files, reads points from map or cloud files, and determines map grids and bounds."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.cloud_files import CLOUD_FORMATS, read_cloud
from uwsim.mapping.occupancy_map import OccupancyMap

MAP_SUFFIXES = (".bt", ".ot")
FIRST_LINES = {b"# Octomap OcTree binary file": "bt", b"# Octomap OcTree file": "ot"}

Origin = tuple[float, float, float]
ZERO: Origin = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Bounds:
    """The bounding box of the known voxels of a map: its low and high corners (3,) in the world."""

    low_m: NDArray[np.float64]
    high_m: NDArray[np.float64]


def open_map(path: Path, origin_world_m: Origin = ZERO) -> OccupancyMap:
    """Read a map. Raises OSError if the file cannot be read, ValueError if it is not a valid map."""
    return OccupancyMap.read(path, origin_world_m)


def map_format(path: Path) -> str:
    """Return `bt` or `ot`, from the first line of a valid map file."""
    with path.open("rb") as file:
        return FIRST_LINES.get(file.readline(64).strip(), "bt")


def open_points(path: Path, origin_world_m: Origin = ZERO) -> tuple[NDArray[np.float64], float | None]:
    """Return the occupied voxel centres (n, 3) and resolution of a map file, or the points of a cloud file and None."""
    if path.suffix.lower() in CLOUD_FORMATS:
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


def known_bounds(occupancy: OccupancyMap) -> Bounds | None:
    """Return the bounding box of the known (occupied or free) voxels of a map; None for an empty map."""
    known = [voxels for voxels in (occupancy.occupied_voxels(), occupancy.free_voxels()) if len(voxels)]
    if not known:
        return None
    half_m = occupancy.resolution_m / 2.0
    low = np.min([voxels.min(axis=0) for voxels in known], axis=0) - half_m
    high = np.max([voxels.max(axis=0) for voxels in known], axis=0) + half_m
    return Bounds(low, high)
