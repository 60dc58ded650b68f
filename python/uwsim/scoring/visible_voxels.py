"""The voxels of the true surface that a sonar could have seen along a path: in line of sight and within range."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.voxel_keys import are_in, pack_keys
from uwsim.scoring.surface_ahead import SurfaceAhead
from uwsim.scoring.true_surface import SurfaceSamples, surface_tile_jobs

Item = TypeVar("Item")
Result = TypeVar("Result")

POSE_SPACING_M = 0.25
VISIBILITY_TOLERANCE_M = 0.01
NOTHING: NDArray[np.int64] = np.empty(0, np.int64)


def visible_voxels(
    world: _core.World,
    rays: _core.RayScene,
    resolution_m: float,
    path_world_m: NDArray[np.float64],
    area_world_m: NDArray[np.float64],
    range_max_m: float,
    seen: NDArray[np.int64] = NOTHING,
    ahead: SurfaceAhead | None = None,
) -> NDArray[np.int64]:
    """Return the packed keys (v,), sorted, of the truth voxels that are visible from any pose on the path.

    path_world_m: (n, 3). area_world_m: (k, 2), the polygon outside which no voxel counts. seen: sorted keys of voxels
    in which an exact beam from the path has ended; no more rays are cast to these. ahead: tiles sampled in advance.
    """
    poses = _thinned_path(path_world_m, POSE_SPACING_M)
    if not len(poses):
        return np.empty(0, np.int64)
    box = poses.min(axis=0) - range_max_m, poses.max(axis=0) + range_max_m

    def visible_in(sample: Callable[[], SurfaceSamples]) -> NDArray[np.int64]:
        tile = sample()
        if not len(tile.points_world_m):
            return np.empty(0, np.int64)
        low, high = zip(*((column.min(), column.max()) for column in tile.points_world_m.T), strict=True)
        near = np.linalg.norm(poses - np.clip(poses, low, high), axis=1) <= range_max_m
        if not near.any():
            return np.empty(0, np.int64)
        keys = pack_keys(tile.voxel_keys)
        visible = are_in(keys, seen)
        unknown = ~visible
        if not unknown.any():
            return keys
        asked = unknown[tile.voxel_of_sample]
        visible[unknown] = rays.seen_groups(
            poses[near],
            tile.points_world_m[asked],
            (np.cumsum(unknown) - 1)[tile.voxel_of_sample[asked]],
            np.count_nonzero(unknown),
            range_max_m,
            VISIBILITY_TOLERANCE_M,
        )
        return keys[visible]

    tiles = surface_tile_jobs(world, resolution_m, area_world_m, box) if ahead is None else ahead.tiles()
    visible = list(_in_parallel(visible_in, tiles))
    return np.sort(np.concatenate([np.empty(0, np.int64), *visible]))


def _in_parallel(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield work(item) for each item, in order, using one thread per core; only a few are in progress at a time."""
    threads = len(os.sched_getaffinity(0))
    with ThreadPoolExecutor(threads, "score") as pool:
        pending: deque[Future[Result]] = deque()
        for item in items:
            pending.append(pool.submit(work, item))
            if len(pending) > threads:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()


def _thinned_path(path_world_m: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """Return about one position per spacing_m of the path.

    Every position on the path is within spacing_m, along the path, of one that is returned.
    """
    if not len(path_world_m):
        return np.empty((0, 3))
    flown_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path_world_m, axis=0), axis=1))])
    stops = np.linspace(0.0, flown_m[-1], int(np.ceil(flown_m[-1] / spacing_m)) + 1)
    kept = np.unique(np.append(np.searchsorted(flown_m, stops[:-1]), len(path_world_m) - 1))
    return np.asarray(path_world_m[kept], np.float64)
