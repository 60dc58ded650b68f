"""Scores a map against the true surface: coverage, recall, precision and distances."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.voxel_keys import are_in, pack_keys, sorted_unique, unpack_keys, voxel_centres_m
from uwsim.scoring.seabed_comparison import SeabedComparison, compare_seabed
from uwsim.scoring.true_surface import SurfaceAhead, SurfaceSamples, surface_tile_jobs

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


ROWS_AT_ONCE = 1 << 14
ON_FACE_M = 1e-3
"""Surface this close to a voxel's face lies on it: rounding decides which of the two voxels a point on it is in."""


@dataclass(frozen=True, eq=False)
class MapScore:
    """The score of a map against the true surface.

    Truth voxels are the voxels on the map's grid through which the true surface passes. coverage: fraction, in [0, 1],
    of the visible truth voxels with an occupied voxel at most one voxel away; 0 if none was visible. recall: fraction
    of these voxels that are themselves occupied; where the surface lies on a voxel's face, the voxel across it counts
    as well. recalled_across_faces: how many voxels count for that reason alone. precision: fraction of the occupied
    voxels through which the true surface passes. Distances are from the centres of the occupied voxels to the nearest
    point on the true surface. For an empty map, distances and precision are NaN. visible_voxels: (v,), packed keys of
    the truth voxels that the sonar could have seen. covered: mask (v,) of those that count as covered. false_centres_m:
    (f, 3), centres of occupied voxels without true surface. seabed: the depths of the occupied voxels, in cells as wide
    as a voxel, compared with the terrain; None for an empty map.
    """

    coverage: float
    precision: float
    recall: float
    recalled_across_faces: int
    occupied_voxels: int
    distance_mean_m: float
    distance_p95_m: float
    distance_max_m: float
    resolution_m: float
    visible_voxels: NDArray[np.int64]
    covered: NDArray[np.bool_]
    false_centres_m: NDArray[np.float64]
    seabed: SeabedComparison | None

    @property
    def visible_truth_voxels(self) -> int:
        """Number of truth voxels inside the polygon, in line of sight and within range of a pose on the path."""
        return len(self.covered)

    @property
    def visible_centres_m(self) -> NDArray[np.float64]:
        """Centres of the visible truth voxels, (v, 3)."""
        return voxel_centres_m(unpack_keys(self.visible_voxels), self.resolution_m)

    @property
    def missed_centres_m(self) -> NDArray[np.float64]:
        """Centres of the visible truth voxels that are not covered, (m, 3)."""
        return voxel_centres_m(unpack_keys(self.visible_voxels[~self.covered]), self.resolution_m)


def score_map(
    world: _core.World,
    occupied_centres_m: NDArray[np.floating],
    resolution_m: float,
    path_world_m: NDArray[np.float64],
    area_world_m: NDArray[np.float64],
    range_max_m: float,
    *,
    rays: _core.RayScene | None = None,
    ahead: SurfaceAhead | None = None,
    occupied_were_seen: bool = False,
) -> MapScore:
    """Return the score of occupied voxel centres (n, 3) against the world.

    rays: the world's ray scene, if it already exists. ahead: work already done during the survey of this area, for
    voxels of this resolution. occupied_were_seen: whether the map was built from exact ranges and true poses on this
    path, so that an occupied truth voxel is known to have been seen, without casting a ray.

    Coverage: the truth voxels that count lie inside the polygon area_world_m (k, 2), in line of sight and within
    range_max_m of any position on path_world_m (n, 3). A voxel is covered if it is occupied or has an occupied
    neighbour among the 26 on the map's grid, floor(x / resolution).

    Precision: an occupied voxel is correct if the true surface passes through it or within 1 mm of it, wherever the
    voxel lies. This includes surface below the terrain, which only a map with access to the truth would contain.

    Distance: exact, from each occupied voxel's centre to the true surface, wherever the voxel lies. The centre is at
    most half the diagonal (0.43 m at 0.5 m), and on average about a quarter of the width, from a surface that passes
    through its voxel, so a perfect map does not score zero.

    Raises ValueError if the occupied centres or `ahead` are not on this grid, or if the true surface within range of
    the path has more voxels than true_surface.MAX_VOXELS.
    """
    rays = rays or _core.RayScene(world)
    surface = _core.SurfaceVoxels(rays, resolution_m) if ahead is None else ahead.voxels
    if surface.resolution_m != resolution_m:
        raise ValueError(f"ahead.voxels = {surface.resolution_m:g} m: must be the map's, {resolution_m:g} m")
    occupied_keys = _grid_keys(occupied_centres_m, resolution_m)
    occupied = sorted_unique(occupied_keys)
    seen = occupied if occupied_were_seen else NOTHING
    centres = np.asarray(occupied_centres_m, np.float64)
    any_occupied = len(centres) > 0

    def compared() -> SeabedComparison | None:
        return compare_seabed(world, rays, depth_grid(centres, resolution_m), area_world_m) if any_occupied else None

    with ThreadPoolExecutor(1, "seabed") as pool:  # independent of the rest
        comparison = pool.submit(compared)
        visible = visible_voxels(world, rays, resolution_m, path_world_m, area_world_m, range_max_m, seen, ahead)
        covered = _have_occupied_neighbour(visible, occupied)
        distances = surface.distances_m(occupied_keys)
        right = _hold_surface(surface, occupied_keys, distances, visible)
        is_occupied = are_in(visible, occupied)
        across = _occupied_across_faces(rays, surface, visible[~is_occupied], occupied)
        seabed = comparison.result()
    return MapScore(
        coverage=float(covered.mean()) if len(covered) else 0.0,
        precision=float(right.mean()) if any_occupied else float("nan"),
        recall=float(is_occupied.sum() + across) / len(visible) if len(visible) else 0.0,
        recalled_across_faces=across,
        occupied_voxels=len(centres),
        distance_mean_m=float(distances.mean()) if any_occupied else float("nan"),
        distance_p95_m=float(np.percentile(distances, 95.0)) if any_occupied else float("nan"),
        distance_max_m=float(distances.max()) if any_occupied else float("nan"),
        resolution_m=resolution_m,
        visible_voxels=visible,
        covered=covered,
        false_centres_m=centres[~right],
        seabed=seabed,
    )


def _hold_surface(
    surface: _core.SurfaceVoxels,
    voxels: NDArray[np.int64],
    distances_m: NDArray[np.float64],
    truth: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Return a mask (n,) of voxels that contain true surface. truth: sorted voxels that are known to contain it."""
    undecided = np.flatnonzero(distances_m > surface.resolution_m / 2.0)
    undecided = undecided[~are_in(voxels[undecided], truth)]
    right = np.ones(len(voxels), bool)
    right[undecided] = surface.hold_surface(voxels[undecided], distances_m[undecided])
    return right


def _occupied_across_faces(
    rays: _core.RayScene, surface: _core.SurfaceVoxels, voxels: NDArray[np.int64], occupied: NDArray[np.int64]
) -> int:
    """Return how many voxels have an occupied one across a face on which the surface lies, at five points of it."""
    edge_m = surface.resolution_m
    near = np.abs(surface.distances_m(voxels) - edge_m / 2.0) <= ON_FACE_M
    voxels = voxels[near]
    centres_m = voxel_centres_m(unpack_keys(voxels), edge_m)
    found = np.zeros(len(voxels), bool)
    for axis, side in product(range(3), (-1, 1)):
        out = np.zeros((1, 3), np.int64)
        out[0, axis] = side
        beside = np.flatnonzero(~found & are_in(voxels + pack_keys(out) - pack_keys(0 * out), occupied))
        others = np.delete(np.eye(3), axis, axis=0)
        on_face_m = edge_m * np.vstack([np.zeros(3), others / 4.0, -others / 4.0]) + edge_m / 2.0 * out
        distances_m = rays.distance_m((centres_m[beside, None] + on_face_m).reshape(-1, 3)).reshape(-1, 5)
        found[beside] = (distances_m <= ON_FACE_M).all(axis=1)
    return int(found.sum())


def _grid_keys(centres_m: NDArray[np.floating], resolution_m: float) -> NDArray[np.int64]:
    """Return the packed keys (n,) of voxels from their centres (n, 3)."""
    keys, off = np.empty(len(centres_m), np.int64), 0.0
    for first in range(0, len(keys), ROWS_AT_ONCE):  # in parts that fit into the cache
        part = slice(first, first + ROWS_AT_ONCE)
        cells = np.asarray(centres_m[part], np.float64) / resolution_m
        lowest = np.floor(cells)
        off = max(off, float(np.abs(cells - lowest - 0.5).max()))
        keys[part] = pack_keys(lowest.astype(np.int64))
    if off > 0.1:
        rule = f"must be centres of {resolution_m:g} m voxels: map.origin_world_m must be a multiple of that"
        raise ValueError(f"occupied_centres_m = up to {off * resolution_m:.3g} m off the grid: {rule}")
    return keys


def _have_occupied_neighbour(voxels: NDArray[np.int64], occupied: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of packed keys with an occupied voxel at most one voxel away along each axis."""
    found = np.zeros(len(voxels), bool)
    steps = np.stack(np.meshgrid(*[np.array([0, -1, 1])] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for step in pack_keys(steps) - pack_keys(np.zeros((1, 3), np.int64)):
        missing = np.flatnonzero(~found)
        found[missing] = are_in(voxels[missing] + step, occupied)
    return found
