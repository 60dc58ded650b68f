"""OccupancyMap, the probabilistic voxel map: the Python interface of `_core.OccupancyMap`."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.own_files import require_own
from uwsim.base.sealed import Sealed
from uwsim.mapping.files.formats import MAP_FORMATS
from uwsim.mapping.map_options import InstructionSet, MapEngine, OccupancyModel, OnOutside, map_options, probability
from uwsim.mapping.other_trees import HEADER_BYTES, as_octree
from uwsim.mapping.query_results import (
    Cubes,
    MapChanges,
    MapStatistics,
    OccupancyChanges,
    RayCasts,
    StateGrid,
    VoxelCounts,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MapFormat = Literal["bt", "ot"]
FARTHEST_M = 1e7
"""The largest coordinate of an origin, beyond those of UTM and of the Earth's centre."""


class OccupancyMap(Sealed):
    """A probabilistic voxel map: OctoMap's octree with OctoMap's sensor model.

    resolution_m: edge length of a voxel. OctoMap's cube extends 2**15 voxels from its origin along each axis (+-6.5 km
    at 0.2 m); origin_world_m (3,) moves it to the survey area. Files hold world minus origin, and the origin in a
    comment.

    engine: "octomap" is the reference: the system's octomap::OcTree and its insertPointCloud. "bricks" is uwsim's
    engine, which is much faster and smaller. After the same scans, both give the same bytes of .bt and .ot files. A .bt
    is written by an octomap::OcTree or, from 30 million nodes on, by uwsim's writer with the same bytes, since
    OctoMap's tree would take gigabytes. hit: probability that a voxel with a point in it is occupied, in [0.5, 1).
    miss: the same for a voxel that a ray passes through, in (0, 0.5]. clamping: the limits of the probability that
    scans can give a voxel. The defaults are OctoMap's. instruction_set: used by the bricks kernels, for tests and
    benchmarks; the bytes do not depend on it. on_outside: with "raise", a scan with points outside the cube raises
    ValueError, and nothing is inserted; with "count", such points (all points, if the scan's origin is outside) are
    discarded, and counted in statistics(). Up to 64 MB of voxel storage from deleted maps, and the ray tables, are kept
    for new maps.

    The bytes of a map depend only on the scans and their order. Calls release the GIL; concurrent calls are serialised.
    """

    _fixed_when = "the map is made or read"

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
    ) -> None:
        model = OccupancyModel(hit, miss, clamping)
        options = map_options(engine, model, instruction_set, on_outside)
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
    ) -> Self:
        """Return the map in a .bt or .ot file; the format is recognised by the file's first line, not by its name.

        Raises OSError if the file cannot be read; ValueError if it is not a valid map, or if it may need more than half
        of this machine's memory. Of a ColorOcTree or OcTreeStamped, the occupancy is read, with a warning. A .bt only
        distinguishes occupied from free: its voxels get the clamping limits as probabilities. origin_world_m: the
        origin that the file states, by default.
        """
        occupancy_map = cls.__new__(cls)
        model = OccupancyModel(hit, miss, clamping)
        options = map_options(engine, model, "best", on_outside)
        origin = stated_origin(path) if origin_world_m is None else origin_world_m
        with as_octree(path) as plain:
            occupancy_map._map = _core.OccupancyMap.read(plain, _origin(origin), options)
        return occupancy_map

    @property
    def resolution_m(self) -> float:
        """Edge length of a voxel."""
        return self._map.resolution_m

    @property
    def origin_world_m(self) -> NDArray[np.float64]:
        """The tree's origin in world coordinates, (3,) float64."""
        return self._map.origin_world_m

    @property
    def engine(self) -> MapEngine:
        """The engine: "bricks" or "octomap"."""
        return "octomap" if self._map.engine == _core.MapEngine.OCTOMAP else "bricks"

    def insert(self, ping: object) -> NDArray[np.float32]:
        """Insert a ping of a vehicle's multibeam, as a survey does; return its echoes in the world, (n, 3) float32.

        The ping passes the chain of its sonar: depth string, laser scan and point cloud, without echoes that the
        scenario's survey filters, and without those from the vehicle's own hull. Raises ValueError for a ping that
        Sonar.ping() did not take, such as a copy or a part of a batch, and as insert_scan does.
        """
        chain = getattr(ping, "chain", None)
        if chain is None:
            raise ValueError(
                "ping: does not have its sonar's chain, since Sonar.ping() did not take it; use insert_scan"
            )
        echoes_world_m: NDArray[np.float32] = chain.echoes_of(ping)
        self.insert_scan(echoes_world_m, ping.world_from_sonar[:3, 3], chain.model.range_max_m)  # type: ignore[attr-defined]
        return echoes_world_m

    def insert_scan(self, points_world_m: ArrayLike, origin_world_m: ArrayLike, max_range_m: float = math.inf) -> None:
        """Insert one ping: voxels between the origin and a point are updated as free, voxels with a point as occupied.

        Each voxel is updated once; occupied wins. points_world_m: (n, 3) float32; non-finite points mean no echo and
        are skipped. origin_world_m: (3,), where the ping was sent. For a point farther than max_range_m, only the
        voxels up to that range are updated, as free; rays and points are float32, so choose it a centimetre above the
        longest expected range. Raises ValueError and inserts nothing if the origin is not finite, or if it or a point
        lies outside the cube.
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
        """Insert many pings in order: faster than one by one, with the same result.

        points_world_m: (n, 3) float32, the concatenated points of all pings; not copied. counts: (m,), number of points
        of each ping, n in total. origins_world_m: (m, 3). threads: number of threads that the bricks use; the map does
        not depend on it. Raises ValueError as insert_scan does, and then inserts none of the pings.
        """
        self._map.insert_scans(points_world_m, counts, origins_world_m, max_range_m, threads)

    def occupied_voxels(self) -> NDArray[np.float64]:
        """Return the centres of the occupied voxels, (n, 3) float64, world, at the finest level, in Morton order.

        Raises ValueError if there are more than 100 million.
        """
        return self._map.occupied_voxels()

    def free_voxels(self) -> NDArray[np.float64]:
        """Return the centres of the free voxels, (n, 3) float64, world, at the finest level, in Morton order.

        Raises ValueError if there are more than 100 million.
        """
        return self._map.free_voxels()

    def statistics(self) -> MapStatistics:
        """Return the numbers of voxels and nodes, and the memory used. Traverses the whole map."""
        return MapStatistics(*self._map.statistics())

    def count(self) -> VoxelCounts:
        """Return the numbers of occupied and free voxels, as `statistics` does but much faster."""
        return VoxelCounts(*self._map.count())

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Return the corners, low and high (3,), of the box around the known voxels, in the world; None if empty."""
        found: tuple[NDArray[np.float64], NDArray[np.float64]] | None = self._map.bounds()
        return found

    def state_at(self, points_world_m: ArrayLike) -> NDArray[np.int8]:
        """Return the states (n,) of the voxels at points_world_m (n, 3): 1 occupied, 0 free, -1 unknown or outside."""
        return self._map.state_at(points_world_m)

    def log_odds_at(self, points_world_m: ArrayLike) -> NDArray[np.float32]:
        """Return the log-odds (n,) float32 of the voxels at points_world_m (n, 3); NaN where unknown."""
        return self._map.log_odds_at(points_world_m)

    def probability_at(self, points_world_m: ArrayLike) -> NDArray[np.float64]:
        """Return the probabilities (n,) float64 of the voxels at points_world_m (n, 3); NaN where unknown."""
        return probability(self.log_odds_at(points_world_m))

    def leaves(self) -> Cubes:
        """Return the leaves of OctoMap's pruned tree: maximal cubes of equal voxels."""
        return Cubes(*self._map.leaves())

    def cells(self, depth: int) -> Cubes:
        """Return the cubes at a depth of the tree, 1 to 16 (the finest), that contain known voxels.

        Their log-odds are the maximum over their voxels, as in OctoMap's inner nodes: a cube is occupied if any part of
        it is. Raises ValueError if there are more than 100 million.
        """
        return Cubes(*self._map.cells(depth))

    def voxels_in(self, low_world_m: ArrayLike, high_world_m: ArrayLike) -> Cubes:
        """Return the known voxels of the finest level whose centres are in the closed box with these corners (3,).

        Raises ValueError if there are more than 100 million.
        """
        return Cubes(*self._map.voxels_in(low_world_m, high_world_m))

    def cast_rays(
        self,
        origins_world_m: ArrayLike,
        directions_world: ArrayLike,
        max_range_m: float = math.inf,
        ignore_unknown: bool = False,
    ) -> RayCasts:
        """Cast rays to the first occupied voxel, exactly as octomap::OcTree::castRay does, in float32.

        origins_world_m, directions_world: (n, 3); directions may have any non-zero length. max_range_m: limit of the
        distance to a voxel's centre. ignore_unknown: whether rays pass through unknown voxels. A ray from inside an
        occupied voxel ends there. Raises ValueError for an origin outside the cube.
        """
        return RayCasts(*self._map.cast_rays(origins_world_m, directions_world, ignore_unknown, max_range_m))

    def states_in(self, low_world_m: ArrayLike, high_world_m: ArrayLike) -> StateGrid:
        """Return the states of all voxels whose centres are in the closed box with these corners (3,).

        Raises ValueError if there are more than a billion.
        """
        return StateGrid(*self._map.states_in(low_world_m, high_world_m))

    def spheres_blocked(
        self, centres_world_m: ArrayLike, radius_m: float, *, unknown_blocks: bool = True
    ) -> NDArray[np.bool_]:
        """Return whether spheres at centres_world_m (n, 3) touch an occupied voxel, (n,) bool.

        radius_m: up to 256 voxels. unknown_blocks: whether unknown voxels, and all outside the cube, count as occupied.
        """
        return self._map.spheres_blocked(centres_world_m, radius_m, unknown_blocks)

    def bodies_blocked(
        self,
        points_body_m: ArrayLike,
        positions_world_m: ArrayLike,
        orientations_xyzw: ArrayLike,
        *,
        unknown_blocks: bool = True,
    ) -> NDArray[np.bool_]:
        """Return whether a body has points in occupied voxels, for each of n poses, (n,) bool.

        points_body_m: (k, 3), body frame, as from `body_points`. positions_world_m: (n, 3). orientations_xyzw: (n, 4).
        unknown_blocks: as in `spheres_blocked`. For a path, pass the poses of `poses_along`.
        """
        return self._map.bodies_blocked(points_body_m, positions_world_m, orientations_xyzw, unknown_blocks)

    def unknown_in_view_m3(
        self,
        positions_world_m: ArrayLike,
        orientations_xyzw: ArrayLike,
        horizontal_fov_deg: float,
        vertical_fov_deg: float,
        range_m: float,
    ) -> NDArray[np.float64]:
        """Return the volume of unknown voxels that a sensor would see from each of n poses, (n,) [m^3].

        The view is a pyramid about the pose's x axis, with y to port and z up. A voxel counts once, if a ray within
        range_m reaches it before any occupied voxel; adjacent rays are at most a voxel apart. range_m: up to 400
        voxels. positions_world_m: (n, 3). orientations_xyzw: (n, 4).
        """
        return self._map.unknown_in_view_m3(
            positions_world_m,
            orientations_xyzw,
            math.radians(horizontal_fov_deg),
            math.radians(vertical_fov_deg),
            range_m,
        )

    def changed_voxels(self) -> MapChanges:
        """Return the voxels whose state (unknown, free, occupied) has changed since the last call. For live views.

        The first call returns all known voxels. Voxels that changed back, or whose probability alone changed, are not
        returned. From the first call on, the map keeps a copy of the states, two bits per voxel in mixed areas. Raises
        ValueError if there are more than 100 million; the next call then returns them.
        """
        return MapChanges(*self._map.changed_voxels())

    def changed_occupancy(self) -> OccupancyChanges:
        """Return the voxels that have become occupied, or ceased to be, since the last call. For live views.

        The first call returns all occupied voxels. This is much faster than `changed_voxels` and independent of it:
        each reports the changes since its own last call. Raises ValueError if there are more than 100 million; the next
        call then returns them.
        """
        cells, occupied = self._map.changed_occupancy()
        return OccupancyChanges(cells, occupied.view(np.bool_))

    def merge(self, other: OccupancyMap) -> None:
        """Add another map's log-odds, voxel by voxel; the sum is clamped to this map's limits.

        A voxel that is unknown in one map takes its value from the other. The other map must have the same resolution,
        and an origin that is a whole number of voxels away. Raises ValueError, and changes nothing, if this is not so,
        or if `other` is this map itself or extends beyond this map's cube; OSError if voxels cannot be moved to disk;
        TypeError if `other` is not an OccupancyMap.
        """
        if not isinstance(other, OccupancyMap):
            raise TypeError(f"other = {other!r}: must be an OccupancyMap")
        self._map.merge(other._map)

    @property
    def model(self) -> OccupancyModel:
        """The sensor model for later scans; voxels keep their current values until a scan changes them."""
        hit, miss, lowest, highest = self._map.model()
        return OccupancyModel(hit, miss, (lowest, highest))

    @model.setter
    def model(self, model: OccupancyModel) -> None:
        self._map.set_model(model.hit, model.miss, *model.clamping)

    def to_bytes(self, map_format: MapFormat) -> bytes:
        """Return the bytes that `write` would write to a file with that suffix."""
        first, end, rest = self._map.to_bytes(map_format).partition(b"\n")
        return b"".join((first, end, origin_line(self.origin_world_m), rest))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write a .bt (only occupied or free; small) or an .ot (all probabilities), depending on the path's suffix.

        Packages may add formats (docs/inside/extend.md).

        The map does not change, so it may be written during a survey. The file is replaced atomically: after an
        OSError, the old file is unchanged. Only our own files are replaced. Raises ValueError for another suffix.
        """
        require_map_path(path)
        target = Path(os.fsdecode(path))
        MAP_FORMATS[target.suffix].write(self, target)

    def plot(self) -> Figure:
        """Return a plan view, coloured by height, as a matplotlib Figure."""
        return self.view()

    def view(self) -> Figure:
        """Return the same as `plot`."""
        from uwsim.mapping.plan_view import plan_view  # matplotlib takes a while to import

        return plan_view(self)

    def _repr_png_(self) -> bytes:
        """Return the plan view as a PNG, for notebooks."""
        from uwsim.mapping.plan_view import png

        return png(self)

    def __repr__(self) -> str:
        origin = ", ".join(f"{x:g}" for x in self.origin_world_m)
        held = self.count()
        return (
            f"OccupancyMap(resolution_m={self.resolution_m:g}, origin_world_m=({origin}): "
            f"{held.occupied:,} occupied and {held.free:,} free voxels)"
        )


def _origin(origin_world_m: ArrayLike | None) -> ArrayLike:
    return (0.0, 0.0, 0.0) if origin_world_m is None else origin_world_m


def origin_line(origin_world_m: NDArray[np.float64]) -> bytes:
    """Return the comment that states an origin in a file's header; none for that of the world."""
    return f"# origin_world_m {' '.join(map(str, origin_world_m.tolist()))}\n".encode() if origin_world_m.any() else b""


def stated_origin(path: str | os.PathLike[str]) -> NDArray[np.float64] | None:
    """Return the origin (3,) that a file's header states, if it does. Raises ValueError if it is not three numbers."""
    head = b""
    if Path(path).is_file():
        with Path(path).open("rb") as file:
            head = file.read(HEADER_BYTES).partition(b"\ndata\n")[0]
    found = re.search(rb"^# origin_world_m (.*)$", head, re.MULTILINE)
    if found is None:
        return None
    try:
        origin = np.array(found[1].split(), np.float64)
    except ValueError:
        origin = np.full(3, math.nan)
    if origin.shape != (3,) or not (np.abs(origin) <= FARTHEST_M).all():
        text = found[1][:60].decode(errors="replace")
        rule = f"must be three numbers within {FARTHEST_M:g} m"
        raise ValueError(f"map '{os.fspath(path)}': origin_world_m '{text}': {rule}")
    return origin


def require_map_path(path: str | os.PathLike[str]) -> None:
    """Raise an error if a map cannot be written to a path: to be called before long work.

    Raises ValueError for a suffix that no format of maps has, OSError without a folder, or if the file is not our own.
    """
    target = os.fsdecode(path)
    if Path(target).suffix not in MAP_FORMATS:
        raise ValueError(f"map path '{target}': must end in {' or '.join(MAP_FORMATS)}")
    file = Path(os.path.realpath(target))  # a link remains a link
    if file.is_symlink():  # realpath has followed all but those of a loop
        raise OSError(f"'{target}': cannot be written: it is a loop of symbolic links")
    if not file.parent.is_dir():
        raise FileNotFoundError(f"'{target}': cannot be written: there is no folder '{file.parent}'")
    require_own(file)
