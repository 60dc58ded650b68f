"""How good a map is: how much of what could be seen it holds, and how far what it holds lies from the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.survey.true_surface import SurfaceSamples, packed, sample_surface, voxel_centres_m, voxel_keys

POSE_SPACING_M = 0.25
VISIBILITY_TOLERANCE_M = 0.01


@dataclass(frozen=True, eq=False)
class MapScore:
    """A map against the true surface.

    coverage: share in [0, 1] of the visible truth voxels that have an occupied voxel within one; 0 when none was
    visible. Distances are from the centres of the occupied voxels to the nearest point of the true surface, nan for an
    empty map. visible_centres_m: (v, 3), the truth voxels that could have been seen; covered: (v,), which of them were.
    """

    coverage: float
    occupied_voxels: int
    distance_mean_m: float
    distance_p95_m: float
    distance_max_m: float
    visible_centres_m: NDArray[np.float64]
    covered: NDArray[np.bool_]

    @property
    def visible_truth_voxels(self) -> int:
        """Truth voxels inside the polygon, in line of sight and range from some flown pose."""
        return len(self.covered)

    @property
    def missed_centres_m(self) -> NDArray[np.float64]:
        """(m, 3) centres of the truth voxels that were visible and are not in the map."""
        return self.visible_centres_m[~self.covered]


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

    Distance: exact, from each occupied voxel's centre to the true surface, wherever the voxel lies. A voxel's centre is
    off the surface that runs through it by up to half its diagonal (0.43 m at 0.5 m), about a quarter of its width on
    average: a perfect map does not score zero.

    Raises ValueError when the occupied centres are not those of this grid.
    """
    rays = _core.RayScene(world)
    samples = sample_surface(world, resolution_m, area_world_m)
    seen = _seen_voxels(rays, samples, _thinned(path_world_m, POSE_SPACING_M), range_max_m)
    visible_keys = samples.voxel_keys[seen]
    covered = _has_neighbour(visible_keys, _grid_keys(occupied_centres_m, resolution_m))
    distances = rays.distance_m(np.asarray(occupied_centres_m, np.float64)) if len(occupied_centres_m) else np.empty(0)
    some = len(distances) > 0
    return MapScore(
        coverage=float(covered.mean()) if len(covered) else 0.0,
        occupied_voxels=len(occupied_centres_m),
        distance_mean_m=float(distances.mean()) if some else float("nan"),
        distance_p95_m=float(np.percentile(distances, 95.0)) if some else float("nan"),
        distance_max_m=float(distances.max()) if some else float("nan"),
        visible_centres_m=voxel_centres_m(visible_keys, resolution_m),
        covered=covered,
    )


def _grid_keys(centres_m: NDArray[np.floating], resolution_m: float) -> NDArray[np.int64]:
    keys = voxel_keys(centres_m, resolution_m)
    off_m = np.abs(voxel_centres_m(keys, resolution_m) - centres_m).max(initial=0.0)
    if off_m > 0.1 * resolution_m:
        rule = f"must be voxels of {resolution_m:g} m: map.origin_world_m must be a multiple of that"
        raise ValueError(f"occupied_centres_m = up to {off_m:.3g} m off the grid: {rule}")
    return keys


def _has_neighbour(keys: NDArray[np.int64], occupied_keys: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which keys (n, 3) have an occupied key at most one away on every axis: (n,) bool."""
    found = np.zeros(len(keys), bool)
    occupied = np.unique(packed(occupied_keys))
    if not len(occupied):
        return found
    steps = np.stack(np.meshgrid(*[np.array([0, -1, 1])] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for step in steps:
        missing = np.flatnonzero(~found)
        wanted = packed(keys[missing] + step)
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
    left = np.arange(len(samples.points_world_m))
    for pose in poses_world_m:
        points = samples.points_world_m[left]
        close = np.flatnonzero(np.einsum("ij,ij->i", points - pose, points - pose) <= range_max_m**2)
        if not len(close):
            continue
        visible = rays.visible(pose, points[close], VISIBILITY_TOLERANCE_M)
        found = samples.voxel_of_sample[left[close[visible]]]
        if len(found):
            seen[found] = True
            left = left[~seen[samples.voxel_of_sample[left]]]
            if not len(left):
                break
    return seen
