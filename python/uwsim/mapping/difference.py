"""Compares two maps on the same grid voxel by voxel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
