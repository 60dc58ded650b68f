"""Voxel keys equal OctoMap's."""

import numpy as np

from uwsim.mapping.voxel_keys import pack_keys, sorted_unique, unpack_keys, voxel_keys


def test_keys_are_rounded_down_and_packed_in_order_without_collisions():
    assert voxel_keys(np.array([[-0.01, 0.0, 0.5]]), 0.5).tolist() == [[-1, 0, 1]]
    keys = np.array([[i, j, k] for i in (-32768, -1, 0, 32767) for j in (-32768, 0, 7) for k in (-2, 3)])
    assert np.all(np.diff(pack_keys(keys)) > 0)
    assert np.array_equal(unpack_keys(pack_keys(keys)), keys)


def test_sorted_unique_keys_are_those_of_numpy() -> None:
    keys = np.random.default_rng(4).integers(-50, 50, 500)
    np.testing.assert_array_equal(sorted_unique(keys), np.unique(keys))
    assert len(sorted_unique(keys[:0])) == 0
