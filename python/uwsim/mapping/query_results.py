"""Results of map queries: statistics, cubes, changes and ray casts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.short_repr import ShortRepr
from uwsim.mapping.map_options import probability


class VoxelCounts(NamedTuple):
    """Numbers of voxels at the finest level; a pruned leaf counts as all the voxels that it covers."""

    occupied: int
    free: int


@dataclass(frozen=True)
class MapStatistics:
    """The size of a map. Voxels are counted at the finest level; a pruned leaf counts as all the voxels that it covers.

    nodes: nodes of the pruned tree. memory_bytes: for "bricks", all memory of the map; for "octomap", OctoMap's
    estimate, which omits the allocator's overhead. outside_points: with on_outside="count", the number of points
    discarded so far because they were outside the cube.
    """

    occupied_voxels: int
    free_voxels: int
    nodes: int
    memory_bytes: int
    outside_points: int


@dataclass(frozen=True, eq=False, repr=False)
class Cubes(ShortRepr):
    """Cubes of a map, in Morton order.

    centres_m: (n, 3) float64, world. edges_m: (n,) float64. log_odds: (n,) float32, of the cube being occupied.
    """

    centres_m: NDArray[np.float64]
    edges_m: NDArray[np.float64]
    log_odds: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.log_odds)

    @property
    def states(self) -> NDArray[np.int8]:
        """States, (n,) int8: 1 occupied (a probability of 0.5 or more), 0 free."""
        return (self.log_odds >= 0).astype(np.int8)

    @property
    def probabilities(self) -> NDArray[np.float64]:
        """Probabilities that the cubes are occupied, (n,) float64."""
        return probability(self.log_odds)

    def only(self, which: NDArray[np.bool_]) -> Cubes:
        """Return the cubes selected by a mask (n,), as in `cubes.only(cubes.states == 1)`."""
        return Cubes(self.centres_m[which], self.edges_m[which], self.log_odds[which])


@dataclass(frozen=True, eq=False, repr=False)
class StateGrid(ShortRepr):
    """The states of all voxels of a box.

    states: (nx, ny, nz) int8, 1 occupied, 0 free, -1 unknown. low_centre_world_m: (3,), the centre of states[0, 0, 0].
    """

    states: NDArray[np.int8]
    low_centre_world_m: NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class MapChanges(ShortRepr):
    """Voxels of the finest level that changed, and their current states.

    centres_m: (n, 3) float64, world, in Morton order. states: (n,) int8, 1 occupied, 0 free, -1 unknown.
    """

    centres_m: NDArray[np.float64]
    states: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.states)


@dataclass(frozen=True, eq=False, repr=False)
class OccupancyChanges(ShortRepr):
    """Voxels of the finest level that have become occupied or ceased to be, in Morton order.

    cells: (n, 3) int16, voxel indices from the map's origin; a voxel's centre is at (cell + 0.5) * resolution from it.
    occupied: (n,) bool, whether the voxel is occupied now.
    """

    cells: NDArray[np.int16]
    occupied: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.occupied)


@dataclass(frozen=True, eq=False, repr=False)
class RayCasts(ShortRepr):
    """The end points of rays cast in a map.

    states: (n,) int8: 1 if the ray reached an occupied voxel, 0 if it reached its maximum range or the cube's edge, -1
    if it reached an unknown voxel. voxels_m: (n, 3) float64, world, the centre of each ray's last voxel.
    """

    states: NDArray[np.int8]
    voxels_m: NDArray[np.float64]
