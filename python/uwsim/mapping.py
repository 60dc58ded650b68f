"""Occupancy maps: OctoMap's octree, its probabilities and its files.

world = OccupancyMap(resolution_m=0.2)
world.insert_scan(points_world_m, origin_world_m, max_range_m=55.0)
world.write("lake.bt")
world = OccupancyMap.read("lake.bt")
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core

MapFormat = Literal["bt", "ot"]


@dataclass(frozen=True)
class MapStatistics:
    """How much a map holds. Voxels are counted at the finest level, a pruned leaf as all those it covers.

    nodes: of the pruned tree. memory_bytes: by OctoMap's own reckoning, without the allocator's share.
    """

    occupied_voxels: int
    free_voxels: int
    nodes: int
    memory_bytes: int


class OccupancyMap:
    """A probabilistic voxel map: the system's octomap::OcTree with OctoMap's default sensor model.

    resolution_m: edge of a voxel. OctoMap's cube reaches 2**15 voxels from its origin along each axis (+-6.5 km at
    0.2 m); origin_world_m (3,) moves it to where the survey is. Files hold world minus origin, so whoever moves the
    origin passes it to `read` again.

    The bytes of a map depend on the scans and their order alone. Calls release the GIL and wait for each other.
    """

    def __init__(self, resolution_m: float = 0.2, origin_world_m: ArrayLike | None = None) -> None:
        self._map = _core.OccupancyMap(resolution_m, _origin(origin_world_m))

    @classmethod
    def read(cls, path: str | os.PathLike[str], origin_world_m: ArrayLike | None = None) -> Self:
        """Read a .bt or .ot file, told apart by its first line, not by its name.

        Raises OSError if the file cannot be read, ValueError if it is no sound map. A .bt knows occupied and free, no
        degrees: its voxels come back at the limits of certainty.
        """
        occupancy_map = cls.__new__(cls)
        occupancy_map._map = _core.OccupancyMap.read(os.fspath(path), _origin(origin_world_m))
        return occupancy_map

    @property
    def resolution_m(self) -> float:
        """Edge of a voxel."""
        return self._map.resolution_m

    @property
    def origin_world_m(self) -> NDArray[np.float64]:
        """Where the tree's zero lies, (3,) float64."""
        return self._map.origin_world_m

    def insert_scan(self, points_world_m: ArrayLike, origin_world_m: ArrayLike, max_range_m: float = math.inf) -> None:
        """Add one ping: voxels from the origin to each point are seen free once, those that hold a point occupied once.

        points_world_m: (n, 3) float32; NaN and inf are no echo and are skipped. origin_world_m: (3,), where the ping
        was sent from. Of points farther than max_range_m only the free part of the way counts; the ways and points are
        float32, so leave it a centimetre more than the longest range that may arrive.
        Raises ValueError, inserting nothing, if the origin is not finite, or it or a point lies outside the cube.
        """
        self._map.insert_scan(points_world_m, origin_world_m, max_range_m)

    def occupied_voxels(self) -> NDArray[np.float64]:
        """Centres of the occupied voxels, (n, 3) float64, world, at the finest level, in Morton order.

        Raises ValueError past 100 million of them.
        """
        return self._map.occupied_voxels()

    def free_voxels(self) -> NDArray[np.float64]:
        """Centres of the voxels seen free, (n, 3) float64, world, at the finest level, in Morton order.

        Raises ValueError past 100 million of them.
        """
        return self._map.free_voxels()

    def statistics(self) -> MapStatistics:
        """Voxels, nodes and memory. Prunes the tree first, which loses nothing."""
        return MapStatistics(*self._map.statistics())

    def state_at(self, points_world_m: ArrayLike) -> NDArray[np.int8]:
        """State of the voxels that hold points_world_m, (n, 3): 1 occupied, 0 free, -1 unknown or outside the cube."""
        return self._map.state_at(points_world_m)

    def to_bytes(self, map_format: MapFormat) -> bytes:
        """Return what `write` would put into a file of that suffix."""
        return self._map.to_bytes(map_format)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a .bt (maximum likelihood, small) or an .ot (with all probabilities), by the path's suffix.

        The map stays as it is, so that this may be done in the middle of a survey. The file is replaced whole or not
        at all: on OSError an older one is still there. Raises ValueError on another suffix.
        """
        target = os.fsdecode(path)
        suffix = Path(target).suffix
        if suffix not in (".bt", ".ot"):
            raise ValueError(f"map path '{target}': must end in .bt or .ot")
        self._map.write(target, suffix.removeprefix("."))

    def __repr__(self) -> str:
        origin = ", ".join(f"{x:g}" for x in self.origin_world_m)
        return f"OccupancyMap(resolution_m={self.resolution_m:g}, origin_world_m=({origin}))"


def _origin(origin_world_m: ArrayLike | None) -> ArrayLike:
    return (0.0, 0.0, 0.0) if origin_world_m is None else origin_world_m
