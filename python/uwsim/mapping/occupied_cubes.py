"""Occupied cubes of a map, as fine as a limit on their number allows, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.occupancy_map import OccupancyMap
from uwsim.mapping.voxel_keys import pack_keys, sorted_unique, unpack_keys, voxel_centres_m, voxel_keys


def occupied_cubes(occupancy: OccupancyMap, name: str, most: int) -> tuple[NDArray[np.float64], float]:
    """Return the world centres (n, 3) and edge length [m] of at most `most` cubes, each of 1, 8, 64, ... voxels.

    A cube is occupied if a voxel in it is. name: the map's, for messages. Raises ValueError if no voxel is
    occupied, or more than 100 million are.
    """
    centres = occupancy.occupied_voxels()
    if not len(centres):
        raise ValueError(f"map '{name}': has no occupied voxels: there is nothing to draw")
    origin, edge_m = occupancy.origin_world_m, occupancy.resolution_m
    if len(centres) <= most:
        return centres, edge_m
    keys = sorted_unique(pack_keys(voxel_keys(centres - origin, edge_m)))
    while len(keys) > most:
        keys, edge_m = sorted_unique(pack_keys(unpack_keys(keys) >> 1)), 2.0 * edge_m
    return voxel_centres_m(unpack_keys(keys), edge_m) + origin, edge_m
