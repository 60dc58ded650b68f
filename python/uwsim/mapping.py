"""Occupancy maps: OctoMap's octree to the bit, its probabilities and its files.

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
MapEngine = Literal["bricks", "octomap"]
InstructionSet = Literal["best", "portable", "avx2", "avx512"]

ENGINES = {"bricks": _core.MapEngine.BRICKS, "octomap": _core.MapEngine.OCTOMAP}
INSTRUCTION_SETS = {
    "best": _core.InstructionSet.BEST,
    "portable": _core.InstructionSet.PORTABLE,
    "avx2": _core.InstructionSet.AVX2,
    "avx512": _core.InstructionSet.AVX512,
}


@dataclass(frozen=True)
class MapStatistics:
    """How much a map holds. Voxels are counted at the finest level, a pruned leaf as all those it covers.

    nodes: of the pruned tree. memory_bytes: of "bricks" all that the map holds; of "octomap" by OctoMap's own
    reckoning, without the allocator's share.
    """

    occupied_voxels: int
    free_voxels: int
    nodes: int
    memory_bytes: int


class OccupancyMap:
    """A probabilistic voxel map: OctoMap's octree with OctoMap's sensor model.

    resolution_m: edge of a voxel. OctoMap's cube reaches 2**15 voxels from its origin along each axis (+-6.5 km at
    0.2 m); origin_world_m (3,) moves it to where the survey is. Files hold world minus origin, so whoever moves the
    origin passes it to `read` again.

    engine: "octomap" is the system's octomap::OcTree and its insertPointCloud, the reference; "bricks" is ours, much
    faster and smaller. After the same scans both give the same bytes, .bt and .ot, and either's .bt is written by an
    octomap::OcTree.
    hit, miss: probabilities of a voxel that holds a point, in [0.5, 1), and of one that a ray goes through, in
    (0, 0.5]. clamping: the limits of what scans may make of a voxel. The defaults are OctoMap's.
    instruction_set: of the bricks' inner loops, for tests and benchmarks; the bytes do not depend on it.

    The bytes of a map depend on the scans and their order alone. Calls release the GIL and wait for each other.
    """

    def __init__(
        self,
        resolution_m: float = 0.2,
        origin_world_m: ArrayLike | None = None,
        *,
        engine: MapEngine = "bricks",
        hit: float = 0.7,
        miss: float = 0.4,
        clamping: tuple[float, float] = (0.1192, 0.971),
        instruction_set: InstructionSet = "best",
    ) -> None:
        options = _options(engine, hit, miss, clamping, instruction_set)
        self._map = _core.OccupancyMap(resolution_m, _origin(origin_world_m), options)

    @classmethod
    def read(
        cls,
        path: str | os.PathLike[str],
        origin_world_m: ArrayLike | None = None,
        *,
        engine: MapEngine = "bricks",
        hit: float = 0.7,
        miss: float = 0.4,
        clamping: tuple[float, float] = (0.1192, 0.971),
    ) -> Self:
        """Read a .bt or .ot file, told apart by its first line, not by its name.

        Raises OSError if the file cannot be read, ValueError if it is no sound map. A .bt knows occupied and free, no
        degrees: its voxels come back at the limits of certainty.
        """
        occupancy_map = cls.__new__(cls)
        options = _options(engine, hit, miss, clamping, "best")
        occupancy_map._map = _core.OccupancyMap.read(os.fspath(path), _origin(origin_world_m), options)
        return occupancy_map

    @property
    def resolution_m(self) -> float:
        """Edge of a voxel."""
        return self._map.resolution_m

    @property
    def origin_world_m(self) -> NDArray[np.float64]:
        """Where the tree's zero lies, (3,) float64."""
        return self._map.origin_world_m

    @property
    def engine(self) -> MapEngine:
        """What the map is made of."""
        return "octomap" if self._map.engine == _core.MapEngine.OCTOMAP else "bricks"

    def insert_scan(self, points_world_m: ArrayLike, origin_world_m: ArrayLike, max_range_m: float = math.inf) -> None:
        """Add one ping: voxels from the origin to each point are seen free once, those that hold a point occupied once.

        points_world_m: (n, 3) float32; NaN and inf are no echo and are skipped. origin_world_m: (3,), where the ping
        was sent from. Of points farther than max_range_m only the free part of the way counts; the ways and points are
        float32, so leave it a centimetre more than the longest range that may arrive.
        Raises ValueError, inserting nothing, if the origin is not finite, or it or a point lies outside the cube.
        """
        self._map.insert_scan(points_world_m, origin_world_m, max_range_m)

    def insert_scans(
        self,
        points_world_m: ArrayLike,
        counts: ArrayLike,
        origins_world_m: ArrayLike,
        max_range_m: float = math.inf,
        threads: int = 1,
    ) -> None:
        """Add many pings in their order, which is faster than one by one and gives the same map.

        points_world_m: (n, 3) float32, the points of all pings one after the other, not copied. counts: (m,), how many
        of them each ping has; they add up to n. origins_world_m: (m, 3). threads: of the bricks; the map does not
        depend on it.
        Raises ValueError as insert_scan does, inserting none of them.
        """
        self._map.insert_scans(points_world_m, counts, origins_world_m, max_range_m, threads)

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
        """Voxels, nodes and memory. It goes through the whole map."""
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


def _options(
    engine: str, hit: float, miss: float, clamping: tuple[float, float], instruction_set: str
) -> _core.MapOptions:
    if engine not in ENGINES:
        raise ValueError(f"map.engine = {engine!r}: must be one of {', '.join(ENGINES)}")
    if instruction_set not in INSTRUCTION_SETS:
        raise ValueError(f"map.instruction_set = {instruction_set!r}: must be one of {', '.join(INSTRUCTION_SETS)}")
    lowest, highest = clamping
    return _core.MapOptions(
        engine=ENGINES[engine],
        hit=hit,
        miss=miss,
        clamping_min=lowest,
        clamping_max=highest,
        instruction_set=INSTRUCTION_SETS[instruction_set],
    )
