"""Voxels as a mesh of cubes that rays can be cast at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.voxel_keys import pack_keys, unpack_keys, voxel_keys


def voxel_world(
    occupied_centres_m: NDArray[np.floating], resolution_m: float, *, from_above: bool = False
) -> _core.World:
    """Return a world of cubes, one for each occupied voxel (n, 3); faces between neighbouring cubes are omitted.

    from_above: omit lower faces, too, for a picture that is seen and lit from above: the upper ones are met first.
    """
    occupied = np.unique(pack_keys(voxel_keys(occupied_centres_m, resolution_m)))
    keys = unpack_keys(occupied)
    vertices = []
    for axis in range(3):
        for side in (1,) if axis == 2 and from_above else (0, 1):
            step = np.zeros(3, np.int64)
            step[axis] = 2 * side - 1
            neighbours = pack_keys(keys + step)
            at = np.minimum(np.searchsorted(occupied, neighbours), len(occupied) - 1)
            exposed = keys[occupied[at] != neighbours]
            quad = np.zeros((4, 3), np.int64)
            quad[:, axis] = side
            first, second = (axis + 1) % 3, (axis + 2) % 3
            quad[:, first if side else second] = [0, 1, 1, 0]
            quad[:, second if side else first] = [0, 0, 1, 1]
            vertices.append((exposed[:, None, :] + quad) * resolution_m)
    corners = np.concatenate(vertices).reshape(-1, 3)
    base = np.arange(0, len(corners), 4)[:, None]
    triangles = np.concatenate([base + np.array([0, 1, 2]), base + np.array([0, 2, 3])]).astype(np.uint32)
    world = _core.World()
    world.add_solid("voxels", corners, triangles)
    return world
