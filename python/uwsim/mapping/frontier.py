"""Frontiers of a map: connected clusters of free voxels that border on unknown voxels.

Yamauchi, "A frontier-based approach for autonomous exploration", CIRA 1997, in three dimensions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.mapping.occupancy_map import OccupancyMap

FREE, UNKNOWN = 0, -1


class Frontier(NamedTuple):
    """A cluster of frontier voxels. voxels_world_m: (n, 3), their centres. centre_world_m: (3,), the mean of these."""

    centre_world_m: NDArray[np.float64]
    voxels_world_m: NDArray[np.float64]


def frontiers(
    occupancy_map: OccupancyMap, low_world_m: ArrayLike, high_world_m: ArrayLike, *, voxels_min: int = 1
) -> list[Frontier]:
    """Return the frontiers of a map within a box, largest first.

    A frontier voxel is free and shares a face with an unknown voxel of the box; clusters are connected by faces, edges
    or corners (scipy.ndimage.label). Those with fewer than voxels_min voxels are left out. Raises ValueError for a box
    without voxels, or with more than a billion.
    """
    from scipy import ndimage  # takes a while to import

    if voxels_min < 1:
        raise ValueError(f"voxels_min = {voxels_min}: must be at least 1")
    box = occupancy_map.states_in(low_world_m, high_world_m)
    borders = (box.states == FREE) & ndimage.binary_dilation(box.states == UNKNOWN)
    labels, count = ndimage.label(borders, structure=np.ones((3, 3, 3)))
    places = np.argwhere(borders)
    clusters = labels[borders] - 1
    order = np.argsort(clusters, kind="stable")
    sizes = np.bincount(clusters, minlength=count)
    found = [
        _frontier(box.low_centre_world_m + occupancy_map.resolution_m * voxels)
        for voxels in np.split(places[order], np.cumsum(sizes)[:-1])
        if len(voxels) >= voxels_min
    ]
    return sorted(found, key=lambda frontier: -len(frontier.voxels_world_m))


def _frontier(voxels_world_m: NDArray[np.float64]) -> Frontier:
    return Frontier(voxels_world_m.mean(axis=0), voxels_world_m)
