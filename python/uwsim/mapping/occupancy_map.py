"""The map itself: the face of `_core.OccupancyMap`."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.mapping.results import Cubes, MapChanges, MapStatistics, OccupancyModel, RayCasts, probability

MapFormat = Literal["bt", "ot"]
MapEngine = Literal["bricks", "octomap"]
InstructionSet = Literal["best", "portable", "avx2", "avx512"]
OnOutside = Literal["raise", "count"]

ENGINES = {"bricks": _core.MapEngine.BRICKS, "octomap": _core.MapEngine.OCTOMAP}
INSTRUCTION_SETS = {
    "best": _core.InstructionSet.BEST,
    "portable": _core.InstructionSet.PORTABLE,
    "avx2": _core.InstructionSet.AVX2,
    "avx512": _core.InstructionSet.AVX512,
}
ON_OUTSIDE = ("raise", "count")


class OccupancyMap:
    """A probabilistic voxel map: OctoMap's octree with OctoMap's sensor model.

    resolution_m: edge of a voxel. OctoMap's cube reaches 2**15 voxels from its origin along each axis (+-6.5 km at
    0.2 m); origin_world_m (3,) moves it to where the survey is. Files hold world minus origin, so whoever moves the
    origin passes it to `read` again.

    engine: "octomap" is the system's octomap::OcTree and its insertPointCloud, the reference; "bricks" is ours, much
    faster and smaller. After the same scans both give the same bytes, .bt and .ot, and either's .bt is written by an
    octomap::OcTree (with a memory_limit_mb, or from 30 million nodes on, by us, as its tree would take gigabytes; the
    same bytes).
    hit, miss: probabilities of a voxel that holds a point, in [0.5, 1), and of one that a ray goes through, in
    (0, 0.5]. clamping: the limits of what scans may make of a voxel. The defaults are OctoMap's.
    instruction_set: of the bricks' inner loops, for tests and benchmarks; the bytes do not depend on it.
    on_outside: whether scans with points outside the cube "raise" ValueError and are not inserted, or lose those points
    (all, if the origin is outside), which statistics() "count"s.
    memory_limit_mb: what the bricks may take of memory, near enough: a batch of scans comes on top, and what is kept
    for changed_voxels. The parts of the map that were not used for longest go to a file without a name in spill_dir (by
    default the system's folder for temporary files, which must not itself be in memory), gone with the process however
    it ends, and come back when they are used. The bytes do not depend on it. Inserting raises OSError, having inserted
    nothing, while that file cannot be written; the map is whole.
    What maps that are gone leave of their memory is kept for the next ones, 64 MB of voxels at most and rays' tables.

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
        on_outside: OnOutside = "raise",
        memory_limit_mb: float | None = None,
        spill_dir: str | os.PathLike[str] | None = None,
    ) -> None:
        model = OccupancyModel(hit, miss, clamping)
        options = _options(engine, model, instruction_set, on_outside, memory_limit_mb, spill_dir)
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
        on_outside: OnOutside = "raise",
        memory_limit_mb: float | None = None,
        spill_dir: str | os.PathLike[str] | None = None,
    ) -> Self:
        """Read a .bt or .ot file, told apart by its first line, not by its name.

        Raises OSError if the file cannot be read, ValueError if it is no sound map, or one that may need more than half
        of this machine's memory and has no memory_limit_mb. A .bt knows occupied and free, no degrees: its voxels come
        back at the limits of certainty.
        """
        occupancy_map = cls.__new__(cls)
        model = OccupancyModel(hit, miss, clamping)
        options = _options(engine, model, "best", on_outside, memory_limit_mb, spill_dir)
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

    def log_odds_at(self, points_world_m: ArrayLike) -> NDArray[np.float32]:
        """Log-odds, (n,) float32, that the voxels of points_world_m, (n, 3), are occupied; NaN where unknown."""
        return self._map.log_odds_at(points_world_m)

    def probability_at(self, points_world_m: ArrayLike) -> NDArray[np.float64]:
        """Probability, (n,) float64, that the voxels of points_world_m, (n, 3), are occupied; NaN where unknown."""
        return probability(self.log_odds_at(points_world_m))

    def leaves(self) -> Cubes:
        """The leaves of OctoMap's pruned tree: cubes of voxels that are equal, as large as they can be."""
        return Cubes(*self._map.leaves())

    def cells(self, depth: int) -> Cubes:
        """Cubes at a depth of the tree, 1 to 16 (the finest), of which something is known.

        Their log-odds are the greatest of the voxels in them, as in OctoMap's inner nodes: a cube counts as occupied if
        any part of it is. Raises ValueError past 100 million.
        """
        return Cubes(*self._map.cells(depth))

    def voxels_in(self, low_world_m: ArrayLike, high_world_m: ArrayLike) -> Cubes:
        """The known voxels of the finest level whose centres lie in a box, corners (3,), its faces included.

        Raises ValueError past 100 million.
        """
        return Cubes(*self._map.voxels_in(low_world_m, high_world_m))

    def cast_rays(
        self,
        origins_world_m: ArrayLike,
        directions_world: ArrayLike,
        max_range_m: float = math.inf,
        ignore_unknown: bool = False,
    ) -> RayCasts:
        """Follow rays to the first occupied voxel, the same as octomap::OcTree::castRay, in float32.

        origins_world_m, directions_world: (n, 3), of any length but zero. max_range_m: to a voxel's centre. With
        ignore_unknown rays go on through the unknown. An origin in an occupied voxel ends there. Raises ValueError on
        an origin outside the cube.
        """
        return RayCasts(*self._map.cast_rays(origins_world_m, directions_world, ignore_unknown, max_range_m))

    def changed_voxels(self) -> MapChanges:
        """The voxels whose state, unknown, free or occupied, is another than at the last call: for a live view.

        The first call gives all that are known. A voxel that changed and changed back is not given, nor one whose
        probability alone changed. From the first call on the map keeps a copy of the states, two bits a voxel where
        they are mixed. Raises ValueError past 100 million; the next call then gives them.
        """
        return MapChanges(*self._map.changed_voxels())

    def merge(self, other: OccupancyMap) -> None:
        """Add another map's log-odds, voxel by voxel; the sum is clamped to this map's limits.

        What is unknown to one takes the other's value. The other must be of this resolution and about this origin or
        one a whole number of voxels away. Raises ValueError, having changed nothing, if it is not, is this very map or
        reaches outside this map's cube; OSError if what must leave memory cannot; TypeError if it is no OccupancyMap.
        """
        if not isinstance(other, OccupancyMap):
            raise TypeError(f"other = {other!r}: must be an OccupancyMap")
        self._map.merge(other._map)

    @property
    def model(self) -> OccupancyModel:
        """Probabilities and limits for the scans to come: voxels stay as they are until a scan changes them."""
        hit, miss, lowest, highest = self._map.model()
        return OccupancyModel(hit, miss, (lowest, highest))

    @model.setter
    def model(self, model: OccupancyModel) -> None:
        self._map.set_model(model.hit, model.miss, *model.clamping)

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
    engine: str,
    model: OccupancyModel,
    instruction_set: str,
    on_outside: str,
    memory_limit_mb: float | None,
    spill_dir: str | os.PathLike[str] | None,
) -> _core.MapOptions:
    for name, value, known in (
        ("engine", engine, ENGINES),
        ("instruction_set", instruction_set, INSTRUCTION_SETS),
        ("on_outside", on_outside, ON_OUTSIDE),
    ):
        if value not in known:
            raise ValueError(f"map.{name} = {value!r}: must be one of {', '.join(known)}")
    lowest, highest = model.clamping
    return _core.MapOptions(
        engine=ENGINES[engine],
        hit=model.hit,
        miss=model.miss,
        clamping_min=lowest,
        clamping_max=highest,
        instruction_set=INSTRUCTION_SETS[instruction_set],
        count_outside=on_outside == "count",
        memory_limit_mb=memory_limit_mb,
        spill_folder="" if spill_dir is None else os.fsdecode(spill_dir),
    )
