"""Changes between two visits: groups of voxels that have appeared or vanished between two maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from uwsim.mapping.difference import map_difference
from uwsim.mapping.occupancy_map import OccupancyMap

BESIDE = 1.8  # in voxels: a voxel this close to an occupied voxel of the other map belongs to the same surface
TOGETHER = 2.5  # in voxels: largest distance between neighbours in a group


@dataclass(frozen=True, eq=False)
class MapChange:
    """A group of voxels that appeared or vanished. voxels_m: voxel centres (n, 3)."""

    kind: Literal["appeared", "vanished"]
    voxels_m: NDArray[np.float64]

    @property
    def middle_world_m(self) -> NDArray[np.float64]:
        """The centre (3,) of the bounding box of the voxels."""
        return np.asarray(0.5 * (self.voxels_m.min(axis=0) + self.voxels_m.max(axis=0)))

    @property
    def size_m(self) -> NDArray[np.float64]:
        """The extent (3,) of the voxel centres along each axis."""
        return np.asarray(np.ptp(self.voxels_m, axis=0))


def map_changes(before: OccupancyMap, after: OccupancyMap, smallest: int = 12) -> list[MapChange]:
    """Return the groups of voxels that appeared or vanished between two maps of the same area, largest first.

    A voxel has appeared if it is occupied in `after`, and in `before` was known to be free and had no occupied
    neighbour; vanished is the reverse. Voxels observed on only one visit do not count as changes. smallest: the number
    of voxels below which a group is considered noise. Raises ValueError unless both maps have the same grid.
    """
    differing = map_difference(before, after)
    changes = [
        *_groups("appeared", differing.only_second_m, before, smallest),
        *_groups("vanished", differing.only_first_m, after, smallest),
    ]
    return sorted(changes, key=lambda change: -len(change.voxels_m))


def _groups(
    kind: Literal["appeared", "vanished"], voxels_m: NDArray[np.float64], other: OccupancyMap, smallest: int
) -> list[MapChange]:
    """Return groups of the voxels that are free in the other map and not adjacent to any voxel occupied there."""
    edge_m = other.resolution_m
    free = voxels_m[other.state_at(voxels_m) == 0] if len(voxels_m) else voxels_m
    occupied = other.occupied_voxels()
    if len(free) and len(occupied):
        free = free[cKDTree(occupied).query(free)[0] > BESIDE * edge_m]
    if not len(free):
        return []
    pairs = cKDTree(free).query_pairs(TOGETHER * edge_m, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(free), len(free)))
    _, group = connected_components(graph, directed=False)
    groups = [free[group == k] for k in range(group.max() + 1)]
    return [MapChange(kind, members) for members in groups if len(members) >= smallest]
