"""Integer keys of voxels on OctoMap's grid, as rows (n, 3) or packed into one integer each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

KEY_BITS = 21
KEY_OFFSET = 1 << (KEY_BITS - 1)


def voxel_keys(points_world_m: NDArray[np.floating], resolution_m: float) -> NDArray[np.int64]:
    """Return the keys of the voxels that contain points (n, 3): floor(x / resolution) per axis, as in OctoMap."""
    return np.floor(np.asarray(points_world_m, np.float64) / resolution_m).astype(np.int64)


def voxel_centres_m(keys: NDArray[np.int64], resolution_m: float) -> NDArray[np.float64]:
    """Return the centres (n, 3) of the voxels with keys (n, 3)."""
    return np.asarray((keys + 0.5) * resolution_m, np.float64)


def pack_keys(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return keys (n, 3) within +-2^20 (OctoMap's are within 2^15) as sortable integers (n,), x most significant."""
    shifted = keys + KEY_OFFSET
    return (shifted[:, 0] << (2 * KEY_BITS)) | (shifted[:, 1] << KEY_BITS) | shifted[:, 2]


def sorted_unique(packed_keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return packed keys (n,), sorted and unique; np.unique does the same but is ten times slower."""
    keys = np.sort(packed_keys)
    return keys[np.concatenate([[True], keys[1:] != keys[:-1]])] if len(keys) else keys


def unpack_keys(packed_keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the keys (n, 3) that pack_keys has packed into (n,)."""
    shifts = np.array([2 * KEY_BITS, KEY_BITS, 0])
    return np.asarray(((packed_keys[:, None] >> shifts) & ((1 << KEY_BITS) - 1)) - KEY_OFFSET, np.int64)


def are_in(keys: NDArray[np.int64], sorted_keys: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of the packed keys (n,) that are among the sorted keys."""
    if not len(sorted_keys):
        return np.zeros(len(keys), bool)
    at = np.minimum(np.searchsorted(sorted_keys, keys), len(sorted_keys) - 1)
    return np.asarray(sorted_keys[at] == keys)
