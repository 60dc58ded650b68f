"""Submaps: pieces of a flight that are short enough not to have drifted in themselves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from uwsim.closure.track import PingTrack
from uwsim.mapping.clouds import voxel_grid

Array = NDArray[np.float64]
LENGTH_S = 25.0  # assumed: the estimate drifts by some centimetres in it, and it is tens of metres long
CELL_M = 2.0  # of the plan in which overlaps are looked for
FINE_M = 0.6  # voxels of the clouds that are matched
NEIGHBOURS = 12  # that a plane goes through
TURN_RAD = 1.0  # a submap ends where the vehicle has turned by so much


@dataclass(frozen=True, eq=False)
class Submap:
    """Pings from `first` until before `end`. anchor_m: (2,), where the vehicle was halfway; points by the estimate."""

    first: int
    end: int
    time_s: float
    anchor_m: Array
    std_m: float
    points_world_m: NDArray[np.float32]
    cells: frozenset[tuple[int, int]]

    @cached_property
    def tree(self) -> cKDTree:
        """Of the points."""
        return cKDTree(self.points_world_m)

    @cached_property
    def normals(self) -> Array:
        """Of the planes through each point's nearest ones, (n, 3): the direction of their least spread."""
        points = np.asarray(self.points_world_m, np.float64)
        around = points[self.tree.query(points, k=min(NEIGHBOURS, len(points)))[1].reshape(len(points), -1)]
        around -= around.mean(axis=1, keepdims=True)
        return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0])

    def overlap(self, other: Submap) -> float:
        """Return the share of the smaller plan that lies in both."""
        return len(self.cells & other.cells) / max(min(len(self.cells), len(other.cells)), 1)


def submaps(track: PingTrack) -> list[Submap]:
    """Cut a track into submaps."""
    if not len(track):
        return []
    starts = [0]
    for k in range(1, len(track)):
        first = starts[-1]
        is_long = track.times_s[k] - track.times_s[first] >= LENGTH_S
        if is_long or abs(_turn_rad(track, first, k)) > TURN_RAD:
            starts.append(k)
    made = (_submap(track, first, end) for first, end in zip(starts, [*starts[1:], len(track)], strict=True))
    return [submap for submap in made if len(submap.points_world_m)]


def _submap(track: PingTrack, first: int, end: int) -> Submap:
    middle = (first + end) // 2
    points = voxel_grid(np.concatenate([track.points_world_m(k) for k in range(first, end)]).astype(np.float32), FINE_M)
    cells = np.unique(np.floor(points[:, :2] / CELL_M).astype(np.int64), axis=0)
    return Submap(
        first,
        end,
        track.times_s[middle],
        track.world_from_body[middle][:2, 3],
        track.std_m[middle],
        points,
        frozenset(map(tuple, cells.tolist())),
    )


def _turn_rad(track: PingTrack, first: int, k: int) -> float:
    before, now = track.world_from_body[first][:2, 0], track.world_from_body[k][:2, 0]
    return float(np.arctan2(before[0] * now[1] - before[1] * now[0], before @ now))
