"""What a map takes and answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class OccupancyModel:
    """OctoMap's sensor model (Hornung et al. 2013), as probabilities; the defaults are OctoMap's.

    hit: of a voxel that holds a point, in [0.5, 1). miss: of one that a ray goes through, in (0, 0.5]. clamping: lowest
    and highest of what scans may make of a voxel.
    """

    hit: float = 0.7
    miss: float = 0.4
    clamping: tuple[float, float] = (0.1192, 0.971)


@dataclass(frozen=True)
class MapStatistics:
    """How much a map holds. Voxels are counted at the finest level, a pruned leaf as all those it covers.

    nodes: of the pruned tree. memory_bytes: of "bricks" all that the map holds in memory; of "octomap" by OctoMap's own
    reckoning, without the allocator's share. outside_points: points left out so far, with on_outside="count".
    evictions: how often a part of the map left memory, with a memory_limit_mb.
    """

    occupied_voxels: int
    free_voxels: int
    nodes: int
    memory_bytes: int
    outside_points: int
    evictions: int


@dataclass(frozen=True, eq=False)
class Cubes:
    """Cubes of a map, in Morton order.

    centres_m: (n, 3) float64, world. edges_m: (n,) float64. log_odds: (n,) float32 of being occupied.
    """

    centres_m: NDArray[np.float64]
    edges_m: NDArray[np.float64]
    log_odds: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.log_odds)

    @property
    def states(self) -> NDArray[np.int8]:
        """(n,) int8: 1 occupied (a probability of a half on), 0 free."""
        return (self.log_odds >= 0).astype(np.int8)

    @property
    def probabilities(self) -> NDArray[np.float64]:
        """(n,) float64, of being occupied."""
        return probability(self.log_odds)

    def only(self, which: NDArray[np.bool_]) -> Cubes:
        """Those where `which`, (n,), is true: `cubes.only(cubes.states == 1)`."""
        return Cubes(self.centres_m[which], self.edges_m[which], self.log_odds[which])


@dataclass(frozen=True, eq=False)
class MapChanges:
    """Voxels of the finest level and what they are now.

    centres_m: (n, 3) float64, world, in Morton order. states: (n,) int8, 1 occupied, 0 free, -1 unknown.
    """

    centres_m: NDArray[np.float64]
    states: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.states)


@dataclass(frozen=True, eq=False)
class RayCasts:
    """Where rays end in a map.

    states: (n,) int8: 1 the ray came to an occupied voxel, 0 to its greatest range or the cube's edge, -1 to an unknown
    voxel. voxels_m: (n, 3) float64, world, the centre of that voxel.
    """

    states: NDArray[np.int8]
    voxels_m: NDArray[np.float64]


def probability(log_odds: NDArray[np.float32]) -> NDArray[np.float64]:
    """1 / (1 + exp(-log_odds)); NaN stays NaN."""
    return 1.0 / (1.0 + np.exp(-log_odds.astype(np.float64)))
