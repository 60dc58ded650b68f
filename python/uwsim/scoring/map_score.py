"""Scores a map against the true surface: coverage, recall, precision and distances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.voxel_keys import are_in, pack_keys, sorted_unique, unpack_keys, voxel_centres_m, voxel_keys
from uwsim.scoring.seabed_comparison import SeabedComparison, compare_seabed
from uwsim.scoring.visible_voxels import NOTHING, visible_voxels

TOUCH_M = 1.0e-3  # a surface this close to a voxel counts as inside: points are rounded before they are mapped
HALVINGS = 5


@dataclass(frozen=True, eq=False)
class MapScore:
    """A map's score against the true surface.

    Truth voxels are the voxels, on the map's grid, that the true surface runs through. coverage: share in [0, 1] of the
    visible truth voxels with an occupied voxel at most one voxel away; 0 when none was visible. recall: share of them
    that are occupied themselves. precision: share of the occupied voxels that the true surface runs through. Distances
    run from the centres of the occupied voxels to the nearest point of the true surface; they and precision are nan for
    an empty map. visible_voxels: (v,), packed keys of the truth voxels that the sonar could have seen. covered: (v,)
    bool, which of them count as covered. false_centres_m: (f, 3), occupied voxels without true surface. seabed: the
    depths of the occupied voxels, in cells as wide as a voxel, compared with the terrain; None for an empty map.
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
    seabed: SeabedComparison | None

    @property
    def visible_truth_voxels(self) -> int:
        """Number of truth voxels inside the polygon, in line of sight and within range of a flown pose."""
        return len(self.covered)

    @property
    def visible_centres_m(self) -> NDArray[np.float64]:
        """(v, 3) centres of the visible truth voxels."""
        return voxel_centres_m(unpack_keys(self.visible_voxels), self.resolution_m)

    @property
    def missed_centres_m(self) -> NDArray[np.float64]:
        """(m, 3) centres of the visible truth voxels that are not covered."""
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
    occupied_were_seen: bool = False,
) -> MapScore:
    """Score occupied voxel centres (n, 3) against the world.

    rays: the world's own scene, if there is one already. occupied_were_seen: whether the map is made of exact ranges
    and true poses of this path, so that a truth voxel that is occupied has been seen: no ray has to show it again.

    Coverage: the truth voxels that count lie inside the polygon area_world_m (k, 2), in line of sight and within
    range_max_m of any flown position in path_world_m (n, 3). Covered are those that are occupied or have an occupied
    one among their 26 neighbours on the map's grid, floor(x / resolution).

    Precision: an occupied voxel is right when the true surface runs through it or passes within TOUCH_M, wherever the
    voxel lies. Here surface under the terrain counts too (only a map that was given it would hold it).

    Distance: exact, from each occupied voxel's centre to the true surface, wherever the voxel lies. The centre lies off
    the surface that runs through its voxel by up to half the diagonal (0.43 m at 0.5 m), about a quarter of the width
    on average, so a perfect map does not score zero.

    Raises ValueError when the occupied centres are not on this grid, or the true surface within range of the path has
    more voxels than true_surface.MAX_VOXELS.
    """
    rays = rays or _core.RayScene(world)
    occupied_keys = pack_keys(_grid_keys(occupied_centres_m, resolution_m))
    occupied = sorted_unique(occupied_keys)
    seen = occupied if occupied_were_seen else NOTHING
    visible = visible_voxels(world, rays, resolution_m, path_world_m, area_world_m, range_max_m, seen)
    covered = _have_occupied_neighbour(visible, occupied)
    centres = np.ascontiguousarray(occupied_centres_m, np.float64)
    any_occupied = len(centres) > 0
    distances = rays.distance_m(centres) if any_occupied else np.empty(0)
    right = _hold_surface(rays, centres, distances, resolution_m, lambda some: are_in(occupied_keys[some], visible))
    seabed = compare_seabed(world, rays, depth_grid(centres, resolution_m), area_world_m) if any_occupied else None
    return MapScore(
        coverage=float(covered.mean()) if len(covered) else 0.0,
        precision=float(right.mean()) if any_occupied else float("nan"),
        recall=float(are_in(visible, occupied).mean()) if len(visible) else 0.0,
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
    rays: _core.RayScene,
    centres_m: NDArray[np.float64],
    distances_m: NDArray[np.float64],
    edge_m: float,
    are_known_to: Callable[[NDArray[np.int64]], NDArray[np.bool_]],
) -> NDArray[np.bool_]:
    """Return which cubes of edge_m about centres (n, 3) the true surface runs through: (n,) bool.

    distances_m: (n,), from the centres to the surface. Within half an edge it runs through the cube, beyond half a
    diagonal it does not; a cube in between is split into eight, at most HALVINGS times, and its parts decide.
    are_known_to: tells which of some cubes the surface is known to run through; they are not split.
    """
    holds = np.zeros(len(centres_m), bool)
    cube_of, half_m = np.arange(len(centres_m)), edge_m / 2.0
    corners = half_m * (np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3, indexing="ij"), axis=-1).reshape(-1, 3))
    for halving in range(HALVINGS + 1):
        holds[cube_of[distances_m <= half_m + TOUCH_M]] = True
        undecided = np.flatnonzero((distances_m <= np.sqrt(3.0) * half_m + TOUCH_M) & ~holds[cube_of])
        if halving == 0:
            known = are_known_to(undecided)
            holds[undecided[known]] = True
            undecided = undecided[~known]
        cube_of, centres_m = cube_of[undecided], centres_m[undecided]
        if halving == HALVINGS or not len(cube_of):
            break
        centres_m = (centres_m[:, None] + corners).reshape(-1, 3)
        cube_of, corners, half_m = np.repeat(cube_of, 8), corners / 2.0, half_m / 2.0
        distances_m = rays.distance_m(centres_m)
    return holds


def _grid_keys(centres_m: NDArray[np.floating], resolution_m: float) -> NDArray[np.int64]:
    keys = voxel_keys(centres_m, resolution_m)
    off_m = np.abs(voxel_centres_m(keys, resolution_m) - centres_m).max(initial=0.0)
    if off_m > 0.1 * resolution_m:
        rule = f"must be centres of {resolution_m:g} m voxels: map.origin_world_m must be a multiple of that"
        raise ValueError(f"occupied_centres_m = up to {off_m:.3g} m off the grid: {rule}")
    return keys


def _have_occupied_neighbour(voxels: NDArray[np.int64], occupied: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which packed keys (n,) have an occupied voxel at most one away on every axis: (n,) bool."""
    found = np.zeros(len(voxels), bool)
    steps = np.stack(np.meshgrid(*[np.array([0, -1, 1])] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for step in pack_keys(steps) - pack_keys(np.zeros((1, 3), np.int64)):
        missing = np.flatnonzero(~found)
        found[missing] = are_in(voxels[missing] + step, occupied)
    return found
