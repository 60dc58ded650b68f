"""Submaps: segments of a flight short enough that drift within them is negligible."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from uwsim.mapping.closure.track import PingTrack
from uwsim.mapping.clouds import voxel_grid

Array = NDArray[np.float64]
LENGTH_S = 25.0  # assumed: the vehicle moves tens of metres in this time, and its estimate drifts by a few centimetres
CELL_M = 2.0  # cells of the plan in which overlaps are found
FINE_M = 0.6  # voxels of the point clouds that are matched
NEIGHBOURS = 12  # points to which each plane is fitted
TURN_RAD = 1.0  # a submap ends where the vehicle has turned by more than this
JUMP_M = 0.3  # a submap also ends where the estimate jumps by more than this between two pings
AROUND = 3  # pings before and after, whose median step is taken as the vehicle's true motion


@dataclass(frozen=True, eq=False)
class Submap:
    """The pings from `first` up to but excluding `end`, at their estimated poses.

    time_s, anchor_m (2,), std_m: time, estimated vehicle position and its standard deviation at the middle ping.
    jump_m: jump (2,) of the estimate at the start of the submap; usually zero. cells: the cells of CELL_M that contain
    points.
    """

    first: int
    end: int
    time_s: float
    anchor_m: Array
    jump_m: Array
    std_m: float
    points_world_m: NDArray[np.float32]
    cells: frozenset[tuple[int, int]]

    @cached_property
    def tree(self) -> cKDTree:
        """A search tree over the points."""
        return cKDTree(self.points_world_m)

    @cached_property
    def normals(self) -> Array:
        """Normals (n, 3) of the planes fitted to each point's nearest neighbours: the directions of least spread."""
        points = np.asarray(self.points_world_m, np.float64)
        around = points[self.tree.query(points, k=min(NEIGHBOURS, len(points)))[1].reshape(len(points), -1)]
        around -= around.mean(axis=1, keepdims=True)
        return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0])

    def overlap(self, other: Submap) -> float:
        """Return the area, seen from above, that both submaps share, as a fraction of the smaller one's area."""
        return len(self.cells & other.cells) / max(min(len(self.cells), len(other.cells)), 1)


def submaps(track: PingTrack) -> list[Submap]:
    """Cut a track into submaps."""
    if not len(track):
        return []
    starts, jumps_m = [0], _jumps_m(track)
    for k in range(1, len(track)):
        first = starts[-1]
        is_long = track.times_s[k] - track.times_s[first] >= LENGTH_S
        if is_long or jumps_m[k].any() or abs(_turn_rad(track, first, k)) > TURN_RAD:
            starts.append(k)
    made = (
        _submap(track, first, end, jumps_m[first]) for first, end in zip(starts, [*starts[1:], len(track)], strict=True)
    )
    return [submap for submap in made if len(submap.points_world_m) or submap.jump_m.any()]


def _jumps_m(track: PingTrack) -> Array:
    """Return the jump (n, 2) of the estimate just before each ping; zero where there is none."""
    steps = np.diff(
        [pose[:2, 3] for pose in track.world_from_body], axis=0, prepend=track.world_from_body[0][None, :2, 3]
    )
    jumps = np.zeros_like(steps)
    for k in range(1, len(steps)):
        usual = np.median(steps[max(1, k - AROUND) : k + AROUND + 1], axis=0)
        if np.linalg.norm(steps[k] - usual) > JUMP_M:
            jumps[k] = steps[k] - usual
    return jumps


def _submap(track: PingTrack, first: int, end: int, jump_m: Array) -> Submap:
    middle = (first + end) // 2
    points = voxel_grid(np.concatenate([track.points_world_m(k) for k in range(first, end)]).astype(np.float32), FINE_M)
    cells = np.unique(np.floor(points[:, :2] / CELL_M).astype(np.int64), axis=0)
    return Submap(
        first,
        end,
        track.times_s[middle],
        track.world_from_body[middle][:2, 3],
        jump_m,
        track.std_m[middle],
        points,
        frozenset(map(tuple, cells.tolist())),
    )


def _turn_rad(track: PingTrack, first: int, k: int) -> float:
    before, now = track.world_from_body[first][:2, 0], track.world_from_body[k][:2, 0]
    return float(np.arctan2(before[0] * now[1] - before[1] * now[0], before @ now))
