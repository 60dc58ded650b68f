"""Compares two maps of the same area: voxel by voxel, and the groups of voxels that have appeared or vanished."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from uwsim.mapping.files.map_files import require_same_grid
from uwsim.mapping.occupancy_map import OccupancyMap

STATES = ("occupied", "free", "unknown")
_STATE_CODES = (1, 0, -1)
POINTS_PER_QUERY = 1 << 22


@dataclass(frozen=True, eq=False)
class MapDifference:
    """A voxel-by-voxel comparison of two maps.

    counts: (3, 3) int64, number of voxels by state in the first map (row) and in the second (column), in the order of
    STATES; voxels that are unknown in both are not counted. only_first_m, only_second_m, both_m: (n, 3), world, centres
    of the voxels that are occupied only in the first map, only in the second, and in both.
    """

    counts: NDArray[np.int64]
    only_first_m: NDArray[np.float64]
    only_second_m: NDArray[np.float64]
    both_m: NDArray[np.float64]
    resolution_m: float

    @property
    def differing(self) -> int:
        """Number of voxels whose states differ."""
        return int(self.counts.sum() - np.trace(self.counts))


def map_difference(first: OccupancyMap, second: OccupancyMap) -> MapDifference:
    """Return the difference of two maps. Raises ValueError unless they have the same resolution and origin."""
    require_same_grid(first, second)
    counts = np.zeros((3, 3), np.int64)
    occupied = first.occupied_voxels()
    in_second = _states(second, occupied)
    counts[0] = [np.count_nonzero(in_second == code) for code in _STATE_CODES]
    in_second_free = _states(second, first.free_voxels())
    counts[1] = [np.count_nonzero(in_second_free == code) for code in _STATE_CODES]
    other = second.occupied_voxels()
    in_first = _states(first, other)
    counts[2, 0] = np.count_nonzero(in_first == -1)
    counts[2, 1] = np.count_nonzero(_states(first, second.free_voxels()) == -1)
    return MapDifference(
        counts, occupied[in_second != 1], other[in_first != 1], occupied[in_second == 1], first.resolution_m
    )


def _states(occupancy: OccupancyMap, centres_m: NDArray[np.float64]) -> NDArray[np.int8]:
    """Return the states at the centres, queried in chunks to limit memory use."""
    starts = range(0, len(centres_m), POINTS_PER_QUERY)
    parts = [occupancy.state_at(centres_m[start : start + POINTS_PER_QUERY]) for start in starts]
    return np.concatenate([np.empty(0, np.int8), *parts])


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
