"""How good a map is: how much of what could be seen it holds, and how far what it holds lies from the truth."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.survey.seabed import SeabedError, seabed_error, seabed_grid
from uwsim.survey.true_surface import SurfaceSamples, packed, surface_tiles, unpacked, voxel_centres_m, voxel_keys

POSE_SPACING_M = 0.25
VISIBILITY_TOLERANCE_M = 0.01
TOUCH_M = 1.0e-3  # what lies so close to a voxel may lie in it: points are rounded on their way into the map
HALVINGS = 5


@dataclass(frozen=True, eq=False)
class MapScore:
    """A map against the true surface.

    coverage: share in [0, 1] of the visible truth voxels that have an occupied voxel within one; 0 when none was
    visible. recall: the share of them that are occupied themselves. precision: the share of the occupied voxels that
    the true surface runs through. Distances are from the centres of the occupied voxels to the nearest point of the
    true surface; these and precision are nan for an empty map. visible_voxels: (v,), the truth voxels that could have
    been seen, packed keys on the grid of voxels of resolution_m; covered: (v,), which of them were. false_centres_m:
    (f, 3), occupied voxels that hold no true surface. seabed: the depths of the occupied voxels, in cells as wide as a
    voxel, against the terrain; None for an empty map.
    """

    coverage: float
    precision: float
    recall: float
    occupied_voxels: int
    distance_mean_m: float
    distance_p95_m: float
    distance_max_m: float
    resolution_m: float
    visible_voxels: NDArray[np.int64]
    covered: NDArray[np.bool_]
    false_centres_m: NDArray[np.float64]
    seabed: SeabedError | None

    @property
    def visible_truth_voxels(self) -> int:
        """Truth voxels inside the polygon, in line of sight and range from some flown pose."""
        return len(self.covered)

    @property
    def visible_centres_m(self) -> NDArray[np.float64]:
        """(v, 3) centres of the truth voxels that could have been seen."""
        return voxel_centres_m(unpacked(self.visible_voxels), self.resolution_m)

    @property
    def missed_centres_m(self) -> NDArray[np.float64]:
        """(m, 3) centres of the truth voxels that were visible and are not in the map."""
        return voxel_centres_m(unpacked(self.visible_voxels[~self.covered]), self.resolution_m)


def score_map(
    world: _core.World,
    occupied_centres_m: NDArray[np.floating],
    resolution_m: float,
    path_world_m: NDArray[np.float64],
    area_world_m: NDArray[np.float64],
    range_max_m: float,
) -> MapScore:
    """Score occupied voxel centres (n, 3) against the world.

    Coverage: of the true-surface voxels inside the polygon area_world_m (k, 2) that were in line of sight and within
    range_max_m of any flown position in path_world_m (n, 3), the share with an occupied voxel within one (itself or its
    26 neighbours) on the map's grid, floor(x / resolution).

    Precision: an occupied voxel is right when the true surface runs through it or past it within TOUCH_M, wherever it
    lies. What lies under the terrain counts as surface here (a map that holds it would have been told so).

    Distance: exact, from each occupied voxel's centre to the true surface, wherever the voxel lies. A voxel's centre is
    off the surface that runs through it by up to half its diagonal (0.43 m at 0.5 m), about a quarter of its width on
    average: a perfect map does not score zero.

    Raises ValueError when the occupied centres are not those of this grid, or the true surface within reach of the path
    has more voxels than true_surface.MAX_VOXELS.
    """
    rays = _core.RayScene(world)
    occupied = np.unique(packed(_grid_keys(occupied_centres_m, resolution_m)))
    visible = _visible_voxels(world, rays, resolution_m, path_world_m, area_world_m, range_max_m)
    covered = _has_neighbour(visible, occupied)
    centres = np.ascontiguousarray(occupied_centres_m, np.float64)
    some = len(centres) > 0
    distances = rays.distance_m(centres) if some else np.empty(0)
    right = _holds_surface(rays, centres, distances, resolution_m)
    seabed = seabed_error(world, rays, seabed_grid(centres, resolution_m), area_world_m) if some else None
    return MapScore(
        coverage=float(covered.mean()) if len(covered) else 0.0,
        precision=float(right.mean()) if some else float("nan"),
        recall=float(np.isin(visible, occupied).mean()) if len(visible) else 0.0,
        occupied_voxels=len(centres),
        distance_mean_m=float(distances.mean()) if some else float("nan"),
        distance_p95_m=float(np.percentile(distances, 95.0)) if some else float("nan"),
        distance_max_m=float(distances.max()) if some else float("nan"),
        resolution_m=resolution_m,
        visible_voxels=visible,
        covered=covered,
        false_centres_m=centres[~right],
        seabed=seabed,
    )


def _holds_surface(
    rays: _core.RayScene, centres_m: NDArray[np.float64], distances_m: NDArray[np.float64], edge_m: float
) -> NDArray[np.bool_]:
    """Return which cubes about centres (n, 3), `distances_m` (n,) from the surface, it runs through: (n,) bool.

    Within half an edge it does, past half a diagonal it does not; what is between is halved along each axis, and
    decided by its eight parts, HALVINGS times at most.
    """
    holds = np.zeros(len(centres_m), bool)
    of, half_m = np.arange(len(centres_m)), edge_m / 2.0
    corners = half_m * (np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3, indexing="ij"), axis=-1).reshape(-1, 3))
    for halving in range(HALVINGS + 1):
        holds[of[distances_m <= half_m + TOUCH_M]] = True
        open_yet = (distances_m <= np.sqrt(3.0) * half_m + TOUCH_M) & ~holds[of]
        of, centres_m = of[open_yet], centres_m[open_yet]
        if halving == HALVINGS or not len(of):
            break
        centres_m = (centres_m[:, None] + corners).reshape(-1, 3)
        of, corners, half_m = np.repeat(of, 8), corners / 2.0, half_m / 2.0
        distances_m = rays.distance_m(centres_m)
    return holds


def _grid_keys(centres_m: NDArray[np.floating], resolution_m: float) -> NDArray[np.int64]:
    keys = voxel_keys(centres_m, resolution_m)
    off_m = np.abs(voxel_centres_m(keys, resolution_m) - centres_m).max(initial=0.0)
    if off_m > 0.1 * resolution_m:
        rule = f"must be voxels of {resolution_m:g} m: map.origin_world_m must be a multiple of that"
        raise ValueError(f"occupied_centres_m = up to {off_m:.3g} m off the grid: {rule}")
    return keys


def _visible_voxels(
    world: _core.World,
    rays: _core.RayScene,
    resolution_m: float,
    path_world_m: NDArray[np.float64],
    area_world_m: NDArray[np.float64],
    range_max_m: float,
) -> NDArray[np.int64]:
    """Return the packed keys of the truth voxels that some pose of the path saw, sorted."""
    poses = _thinned(path_world_m, POSE_SPACING_M)
    if not len(poses):
        return np.empty(0, np.int64)
    within = poses.min(axis=0) - range_max_m, poses.max(axis=0) + range_max_m

    def seen_in(tile: SurfaceSamples) -> NDArray[np.int64]:
        low, high = tile.points_world_m.min(axis=0), tile.points_world_m.max(axis=0)
        near = np.linalg.norm(poses - np.clip(poses, low, high), axis=1) <= range_max_m
        return packed(tile.voxel_keys[_seen_voxels(rays, tile, poses[near], range_max_m)])

    visible = list(_in_parallel(seen_in, surface_tiles(world, resolution_m, area_world_m, within)))
    return np.sort(np.concatenate([np.empty(0, np.int64), *visible]))


def _in_parallel(
    work: Callable[[SurfaceSamples], NDArray[np.int64]], tiles: Iterable[SurfaceSamples]
) -> Iterator[NDArray[np.int64]]:
    """Return the work's results in order, from as many threads as there are cores; few tiles are held at a time."""
    threads = len(os.sched_getaffinity(0))
    with ThreadPoolExecutor(threads, "score") as pool:
        pending: deque[Future[NDArray[np.int64]]] = deque()
        for tile in tiles:
            pending.append(pool.submit(work, tile))
            if len(pending) > threads:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()


def _has_neighbour(voxels: NDArray[np.int64], occupied: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which packed keys (n,) have an occupied one at most one away on every axis: (n,) bool."""
    found = np.zeros(len(voxels), bool)
    if not len(occupied):
        return found
    steps = np.stack(np.meshgrid(*[np.array([0, -1, 1])] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for step in packed(steps) - packed(np.zeros((1, 3), np.int64)):
        missing = np.flatnonzero(~found)
        wanted = voxels[missing] + step
        at = np.minimum(np.searchsorted(occupied, wanted), len(occupied) - 1)
        found[missing] = occupied[at] == wanted
    return found


def _thinned(path_world_m: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """Return the path's positions, about one for each spacing_m flown, coarse to fine (first, middle, quarters, ...).

    Every position of the path is within spacing_m, along the path, of one that is kept. In this order the first few
    dozen positions see nearly everything, which is then not tested again.
    """
    if not len(path_world_m):
        return np.empty((0, 3))
    flown_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path_world_m, axis=0), axis=1))])
    stops = np.linspace(0.0, flown_m[-1], int(np.ceil(flown_m[-1] / spacing_m)) + 1)
    kept = np.unique(np.append(np.searchsorted(flown_m, stops[:-1]), len(path_world_m) - 1))
    bits = max(int(len(kept) - 1).bit_length(), 1)
    index = np.arange(1 << bits)
    reversed_index = np.zeros_like(index)
    for bit in range(bits):
        reversed_index |= ((index >> bit) & 1) << (bits - 1 - bit)
    return np.asarray(path_world_m[kept[reversed_index[reversed_index < len(kept)]]], np.float64)


def _seen_voxels(
    rays: _core.RayScene, samples: SurfaceSamples, poses_world_m: NDArray[np.float64], range_max_m: float
) -> NDArray[np.bool_]:
    """Return which voxels have a sample in line of sight and range of any pose: (voxels,) bool."""
    seen = np.zeros(len(samples.voxel_keys), bool)
    left, points = samples.voxel_of_sample, samples.points_world_m
    for pose in poses_world_m:
        away = points - pose
        close = np.flatnonzero(np.einsum("ij,ij->i", away, away) <= range_max_m**2)
        if not len(close):
            continue
        found = left[close[rays.visible(pose, points[close], VISIBILITY_TOLERANCE_M)]]
        if len(found):
            seen[found] = True
            hidden = ~seen[left]
            left, points = left[hidden], points[hidden]
            if not len(left):
                break
    return seen
