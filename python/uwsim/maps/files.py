"""Maps and clouds as the commands take them: opened with a clear error, written whole or not at all."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.cloud_files import FORMATS, read_cloud
from uwsim.mapping import OccupancyMap

MAP_SUFFIXES = (".bt", ".ot")
IDS = {b"# Octomap OcTree binary file": "bt", b"# Octomap OcTree file": "ot"}

Origin = tuple[float, float, float]
ZERO: Origin = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Bounds:
    """Outer faces of the voxels that a map knows, corners (3,), world."""

    low_m: NDArray[np.float64]
    high_m: NDArray[np.float64]


def open_map(path: Path, origin_world_m: Origin = ZERO) -> OccupancyMap:
    """Raises OSError when the file cannot be read, ValueError when it is no sound map."""
    return OccupancyMap.read(path, origin_world_m)


def map_format(path: Path) -> str:
    """Return `bt` or `ot`, by the first line of a file that open_map has taken."""
    with path.open("rb") as file:
        return IDS.get(file.readline(64).strip(), "bt")


def open_points(path: Path, origin_world_m: Origin = ZERO) -> tuple[NDArray[np.float64], float | None]:
    """Return a map's occupied centres and resolution, or a cloud's points and None, by the path's suffix."""
    if path.suffix.lower() in FORMATS:
        return read_cloud(path), None
    occupancy = open_map(path, origin_world_m)
    return occupancy.occupied_voxels(), occupancy.resolution_m


def require_same_grid(first: OccupancyMap, second: OccupancyMap) -> None:
    """Raises ValueError unless two maps are of one resolution and origin."""
    if first.resolution_m != second.resolution_m:
        raise ValueError(
            f"resolution_m = {first.resolution_m:g} and {second.resolution_m:g} m: must be the same in both maps"
        )
    if not np.array_equal(first.origin_world_m, second.origin_world_m):
        raise ValueError("origin_world_m: must be the same in both maps")


def bounds_of(occupancy: OccupancyMap) -> Bounds | None:
    """Return the box of what a map knows, occupied or free; None when it knows nothing."""
    known = [voxels for voxels in (occupancy.occupied_voxels(), occupancy.free_voxels()) if len(voxels)]
    if not known:
        return None
    half_m = occupancy.resolution_m / 2.0
    low = np.min([voxels.min(axis=0) for voxels in known], axis=0) - half_m
    high = np.max([voxels.max(axis=0) for voxels in known], axis=0) + half_m
    return Bounds(low, high)
